//! The window's surface and the overlay's drawing on it.

use crate::gpu_backend::Canvas;
use crate::gpu_device::Gpu;
use crate::picture::Picture;
use crate::{Error, Result};
use std::sync::Arc;
use std::time::Instant;
use winit::window::Window;

/// A window one can draw on, with egui over it.
pub struct Screen {
    /// The window.
    pub window: Arc<Window>,
    /// egui.
    pub egui: egui::Context,
    /// egui's view of the window's events.
    pub egui_state: egui_winit::State,
    surface: wgpu::Surface<'static>,
    config: wgpu::SurfaceConfiguration,
    /// Not while the window is being taken away.
    is_configured: bool,
    /// Not while it is minimised, where that takes its size.
    has_area: bool,
    started: Instant,
    /// Format the scene is drawn in: sRGB.
    scene_format: wgpu::TextureFormat,
    egui_renderer: egui_wgpu::Renderer,
}

impl Screen {
    /// Configures the surface for the window's size.
    pub fn new(gpu: &Gpu, surface: wgpu::Surface<'static>, window: Arc<Window>) -> Result<Self> {
        let offered = surface.get_capabilities(&gpu.adapter).formats;
        let flags = gpu.adapter.get_downlevel_capabilities().flags;
        let views = flags.contains(wgpu::DownlevelFlags::SURFACE_VIEW_FORMATS);
        let (format, scene_format) = formats(&offered, views).ok_or_else(|| Error::Machine {
            what: format!("the window offers no eight-bit format, only {offered:?}"),
            remedy: "use --headless --out picture.png to draw without a window",
        })?;
        let size = window.inner_size();
        let config = wgpu::SurfaceConfiguration {
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
            format,
            color_space: wgpu::SurfaceColorSpace::Auto,
            width: size.width.max(1),
            height: size.height.max(1),
            present_mode: wgpu::PresentMode::AutoVsync,
            desired_maximum_frame_latency: 2,
            alpha_mode: wgpu::CompositeAlphaMode::Auto,
            view_formats: if scene_format == format { vec![] } else { vec![scene_format] },
        };
        configure(&surface, &gpu.device, &config).map_err(|e| Error::Machine {
            what: format!("the window cannot be drawn to: {e}"),
            remedy: "use --headless --out picture.png to draw without a window",
        })?;
        let egui = egui::Context::default();
        egui.set_theme(egui::Theme::Dark);
        let largest = gpu.device.limits().max_texture_dimension_2d as usize;
        let egui_state =
            egui_winit::State::new(egui.clone(), egui::ViewportId::ROOT, &*window, None, None, Some(largest));
        let egui_renderer = egui_wgpu::Renderer::new(&gpu.device, format, egui_wgpu::RendererOptions::default());
        let (is_configured, has_area) = (true, size.width > 0 && size.height > 0);
        let started = Instant::now();
        Ok(Self {
            window,
            egui,
            egui_state,
            surface,
            config,
            is_configured,
            has_area,
            started,
            scene_format,
            egui_renderer,
        })
    }

    /// Pixels.
    pub fn size(&self) -> [u32; 2] {
        [self.config.width, self.config.height]
    }

    /// Format the scene is drawn in.
    pub fn scene_format(&self) -> wgpu::TextureFormat {
        self.scene_format
    }

    /// Follows the window's size.
    pub fn resize(&mut self, device: &wgpu::Device, size: [u32; 2]) {
        let largest = device.limits().max_texture_dimension_2d;
        self.has_area = size.iter().all(|&side| side > 0);
        let [width, height] = size.map(|side| side.clamp(1, largest));
        if [width, height] != self.size() {
            (self.config.width, self.config.height) = (width, height);
            self.is_configured = configure(&self.surface, device, &self.config).is_ok();
        }
    }

    /// What the next frame is drawn on, where there is anything.
    fn next_texture(&mut self, device: &wgpu::Device) -> Option<wgpu::SurfaceTexture> {
        if !self.is_configured {
            self.is_configured = configure(&self.surface, device, &self.config).is_ok();
            return None;
        }
        match self.surface.get_current_texture() {
            wgpu::CurrentSurfaceTexture::Success(frame) | wgpu::CurrentSurfaceTexture::Suboptimal(frame) => Some(frame),
            wgpu::CurrentSurfaceTexture::Outdated | wgpu::CurrentSurfaceTexture::Lost => {
                self.is_configured = configure(&self.surface, device, &self.config).is_ok();
                None
            }
            // Too late, hidden, or refused: the next frame tries again.
            _ => None,
        }
    }

    /// What happened since the last frame, as `egui_winit::State::take_egui_input` has it, but of the size that the window last told: that one
    /// asks the display server, and the answer of one that has gone is a panic.
    fn overlay_input(&mut self) -> egui::RawInput {
        let points_per_pixel = 1.0 / egui_winit::pixels_per_point(&self.egui, &self.window);
        let [width, height] = self.size().map(|side| side as f32 * points_per_pixel);
        let native_pixels_per_point = Some(self.window.scale_factor() as f32);
        let input = self.egui_state.egui_input_mut();
        input.time = Some(self.started.elapsed().as_secs_f64());
        input.screen_rect =
            self.has_area.then(|| egui::Rect::from_min_size(egui::Pos2::ZERO, egui::vec2(width, height)));
        input.viewport_id = egui::ViewportId::ROOT;
        input.viewports.entry(egui::ViewportId::ROOT).or_default().native_pixels_per_point = native_pixels_per_point;
        input.take()
    }

    /// Lays out the overlay.
    pub fn run_overlay(&mut self, show: impl FnMut(&mut egui::Ui)) -> egui::FullOutput {
        let input = self.overlay_input();
        self.egui.run_ui(input, show)
    }

    /// Draws the scene, the overlay over it, and shows both. `false`: there was nothing to draw on this time.
    pub fn present(
        &mut self,
        gpu: &Gpu,
        output: egui::FullOutput,
        scene: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::TextureView) -> Result<()>,
    ) -> Result<bool> {
        gpu.loss.expect_none()?;
        let frame = self.next_texture(&gpu.device);
        let painted = self.paint(gpu, output, frame.as_ref().map(|frame| &frame.texture), scene);
        if let Err(lost) = gpu.loss.expect_none() {
            // Given back, it would be waited for.
            std::mem::forget(frame);
            return Err(lost);
        }
        painted?;
        let Some(frame) = frame else { return Ok(false) };
        self.window.pre_present_notify();
        gpu.queue.present(frame);
        Ok(true)
    }

    /// The same, but into a picture that is read back; waits.
    ///
    /// # Errors
    /// [`Error::Machine`] when it cannot be read back, [`Error::Stages`] without room for it.
    pub fn picture(
        &mut self,
        gpu: &Gpu,
        output: egui::FullOutput,
        scene: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::TextureView) -> Result<()>,
    ) -> Result<Picture> {
        let canvas = Canvas::seen_as(&gpu.device, self.size(), self.config.format, &self.config.view_formats)?;
        self.paint(gpu, output, Some(canvas.texture()), scene)?;
        canvas.read(&gpu.device, &gpu.queue)
    }

    /// Draws scene and overlay into a texture of the surface's format. egui's own textures are kept in step also without one.
    fn paint(
        &mut self,
        gpu: &Gpu,
        mut output: egui::FullOutput,
        into: Option<&wgpu::Texture>,
        scene: impl FnOnce(&mut wgpu::CommandEncoder, &wgpu::TextureView) -> Result<()>,
    ) -> Result<()> {
        self.egui_state.handle_platform_output(&self.window, output.platform_output);
        for (id, deltas) in output.textures_delta.set.drain() {
            for delta in deltas {
                self.egui_renderer.update_texture(&gpu.device, &gpu.queue, id, &delta);
            }
        }
        if let Some(texture) = into {
            let pixels_per_point = output.pixels_per_point;
            let jobs = self.egui.tessellate(output.shapes, pixels_per_point);
            let screen = egui_wgpu::ScreenDescriptor { size_in_pixels: self.size(), pixels_per_point };
            let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            let view_as = |format| {
                texture.create_view(&wgpu::TextureViewDescriptor { format: Some(format), ..Default::default() })
            };
            scene(&mut encoder, &view_as(self.scene_format))?;
            let mut commands = self.egui_renderer.update_buffers(&gpu.device, &gpu.queue, &mut encoder, &jobs, &screen);
            let view = view_as(self.config.format);
            let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("overlay"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                })],
                ..Default::default()
            });
            self.egui_renderer.render(&mut pass.forget_lifetime(), &jobs, &screen);
            commands.push(encoder.finish());
            gpu.queue.submit(commands);
        }
        for id in output.textures_delta.free.drain() {
            self.egui_renderer.free_texture(&id);
        }
        Ok(())
    }
}

/// An error where wgpu would panic: a surface is refused whose window is gone while nobody has heard of its end yet.
fn configure(
    surface: &wgpu::Surface<'_>,
    device: &wgpu::Device,
    config: &wgpu::SurfaceConfiguration,
) -> std::result::Result<(), wgpu::Error> {
    let scope = device.push_error_scope(wgpu::ErrorFilter::Validation);
    surface.configure(device, config);
    pollster::block_on(scope.pop()).map_or(Ok(()), Err)
}

/// Format of the surface and of the scene's view of it: egui wants its colours written as they are, the scene wants
/// sRGB encoding; where a view may not differ from its surface both take the sRGB one.
fn formats(offered: &[wgpu::TextureFormat], views: bool) -> Option<(wgpu::TextureFormat, wgpu::TextureFormat)> {
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba8Unorm, Rgba8UnormSrgb};
    let plain = offered.iter().copied().find(|f| matches!(f, Bgra8Unorm | Rgba8Unorm)).filter(|_| views);
    let srgb = offered.iter().copied().find(|f| matches!(f, Bgra8UnormSrgb | Rgba8UnormSrgb));
    plain.map(|format| (format, format.add_srgb_suffix())).or(srgb.map(|format| (format, format)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use wgpu::TextureFormat::{Bgra8Unorm, Bgra8UnormSrgb, Rgba16Float};

    #[test]
    fn the_scene_is_always_srgb() {
        let both = [Bgra8UnormSrgb, Bgra8Unorm];
        assert_eq!(formats(&both, true), Some((Bgra8Unorm, Bgra8UnormSrgb)));
        assert_eq!(formats(&both, false), Some((Bgra8UnormSrgb, Bgra8UnormSrgb)));
        assert_eq!(formats(&[Rgba16Float], true), None);
    }
}
