//! Frames drawn by the GPU into a texture, and read back.

use crate::crowd::Crowd;
use crate::gpu_device::Gpu;
use crate::picture::Picture;
use crate::scenery::Scenery;
use crate::schedules::Schedules;
use crate::simulation::Simulation;
use crate::{Error, Result};
use crowd_stages::gpu::{CrowdRenderer, RendererOptions, SkinningChoice, buffer_or_error, texture_or_error};
use crowd_stages::{CrowdData, DrawOptions, FrameConfig, FrameTotals, InstanceRecord, Technique};

/// A renderer that draws into a texture of its own.
pub struct GpuBackend {
    gpu: Gpu,
    renderer: CrowdRenderer,
    simulation: Option<Simulation>,
    canvas: Canvas,
}

impl GpuBackend {
    /// Uploads the crowd. `largest_budget`: the largest N that will be asked for.
    pub fn new(gpu: Gpu, crowd: &Crowd, size: [u32; 2], samples: u32, largest_budget: u32) -> Result<Self> {
        check_size(&gpu.device, size, samples)?;
        let format = wgpu::TextureFormat::Rgba8UnormSrgb;
        let options = renderer_options(&gpu.device, crowd, format, samples, largest_budget);
        let mut renderer = CrowdRenderer::new(&gpu.device, &gpu.queue, &crowd.data, options)?;
        renderer.set_instances(&gpu.queue, &crowd.instances)?;
        renderer.set_motion(&gpu.device, &gpu.queue, crowd.schedules.as_ref().map(Schedules::plan))?;
        let Scenery { vertices, triangles } = &crowd.scenery;
        renderer.set_scenery(&gpu.device, &gpu.queue, vertices, triangles)?;
        let canvas = Canvas::new(&gpu.device, size, format)?;
        let simulation = Simulation::of(&gpu, &mut renderer, crowd)?;
        Ok(Self { gpu, renderer, simulation, canvas })
    }

    /// Other instances than before, at most as many as the crowd had first.
    pub fn set_instances(&mut self, instances: &[InstanceRecord]) -> Result<()> {
        Ok(self.renderer.set_instances(&self.gpu.queue, instances)?)
    }

    /// Shows the crowd at a time: simulated here, or from the CPU.
    pub fn show_time(&mut self, crowd: &mut Crowd, time_s: f32) -> Result<()> {
        match &mut self.simulation {
            Some(simulation) => {
                simulation.advance(&self.gpu, time_s);
                wait(&self.gpu.device)
            }
            None if crowd.advance(time_s) => self.set_instances(&crowd.instances),
            None => Ok(()),
        }
    }

    /// Lets the CPU know where everyone is, and simulate from now on.
    pub fn end_simulation(&mut self, crowd: &mut Crowd) -> Result<()> {
        if let Some(simulation) = self.simulation.take() {
            crowd.instances = simulation.instances(&self.gpu)?;
            self.set_instances(&crowd.instances)?;
        }
        Ok(())
    }

    /// `gpu` where a flock is simulated here.
    pub fn simulates(&self) -> bool {
        self.simulation.is_some()
    }

    /// Bakes what the technique wants baked before a frame; no part of its time.
    pub fn bake(&mut self, crowd: &Crowd, config: &FrameConfig, options: DrawOptions) -> Result<()> {
        let Self { gpu, renderer, simulation, .. } = self;
        bake_frame(gpu, renderer, simulation.as_ref(), crowd, config, options)
    }

    /// Draws a frame and waits until it is done.
    pub fn draw(&mut self, config: &FrameConfig, options: DrawOptions) -> Result<FrameTotals> {
        let Self { gpu, renderer, canvas, .. } = self;
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let size = (canvas.size[0], canvas.size[1]);
        renderer.encode(&gpu.device, &gpu.queue, &mut encoder, &canvas.view, size, config, options)?;
        gpu.queue.submit([encoder.finish()]);
        wait(&gpu.device)?;
        Ok(renderer.totals(&gpu.device, true).unwrap_or_default())
    }

    /// Draws until it is settled where vertices are worked out; at once where that was asked for by name.
    pub fn settle_skinning(&mut self, config: &FrameConfig, options: DrawOptions) -> Result<()> {
        let can_try = options.technique == Technique::Bucketed;
        // A trial ends by itself; twice as many frames as that takes.
        for _ in 0..120 {
            if !can_try || self.skinning(options).is_settled {
                break;
            }
            self.draw(config, options)?;
        }
        Ok(())
    }

    /// Where vertices are worked out with these switches, and why there.
    pub fn skinning(&self, options: DrawOptions) -> SkinningChoice {
        self.renderer.skinning(options.skinning)
    }

    /// The newest frame's pixels.
    pub fn picture(&self) -> Result<Picture> {
        self.canvas.read(&self.gpu.device, &self.gpu.queue)
    }

    /// What another camera sees of the newest frame: `seen` is the frame's, `reference` the other one's.
    pub fn reference_picture(&mut self, configs: [&FrameConfig; 2], options: DrawOptions) -> Result<Picture> {
        let Self { gpu, renderer, canvas, .. } = self;
        draw_reference(gpu, renderer, canvas.size, canvas.format, configs, options)
    }

    /// GPU milliseconds by stage of the newest frame.
    pub fn timings_ms(&mut self) -> Vec<(&'static str, f32)> {
        self.renderer.timings_ms()
    }

    /// Vertex shader runs of the newest frame's crowd, where the adapter counts them.
    pub fn vertex_runs(&mut self) -> Option<u64> {
        self.renderer.vertex_runs()
    }

    /// Poses that were worked out in the newest frame, where they are shared.
    pub fn shared_poses(&mut self) -> Result<Option<u32>> {
        Ok(self.renderer.shared_poses(&self.gpu.device, &self.gpu.queue)?)
    }

    /// Bytes of GPU memory.
    pub fn gpu_bytes(&self) -> u64 {
        self.renderer.gpu_bytes() + self.simulation.as_ref().map_or(0, Simulation::gpu_bytes)
    }

    /// The device it draws with.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }
}

/// The static floor's mesh, where that is what is drawn.
pub fn bake_frame(
    gpu: &Gpu,
    renderer: &mut CrowdRenderer,
    simulation: Option<&Simulation>,
    crowd: &Crowd,
    config: &FrameConfig,
    options: DrawOptions,
) -> Result<()> {
    if options.technique == Technique::StaticFloor {
        let simulated = simulation.map(|simulation| simulation.instances(gpu)).transpose()?;
        let instances = simulated.as_ref().unwrap_or(&crowd.instances);
        renderer.bake_floor(&gpu.device, &gpu.queue, &crowd.data, instances, config, options)?;
    }
    Ok(())
}

/// A picture of the newest frame by another camera; waits for it.
pub fn draw_reference(
    gpu: &Gpu,
    renderer: &mut CrowdRenderer,
    size: [u32; 2],
    format: wgpu::TextureFormat,
    configs: [&FrameConfig; 2],
    options: DrawOptions,
) -> Result<Picture> {
    let canvas = Canvas::new(&gpu.device, size, format)?;
    let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("reference") });
    let size = (size[0], size[1]);
    renderer.encode_reference(&gpu.device, &gpu.queue, &mut encoder, &canvas.view, size, configs, options)?;
    gpu.queue.submit([encoder.finish()]);
    canvas.read(&gpu.device, &gpu.queue)
}

/// Sizes that hold every frame of this crowd at budgets up to `largest_budget`, as far as the adapter allows; what does
/// not fit is reported by the stages as overflow.
pub fn renderer_options(
    device: &wgpu::Device,
    crowd: &Crowd,
    color_format: wgpu::TextureFormat,
    sample_count: u32,
    largest_budget: u32,
) -> RendererOptions {
    let needs = Needs::of(&crowd.data, &crowd.instances, largest_budget);
    let held = |count: u64| u32::try_from(count).unwrap_or(u32::MAX).max(1);
    let options = RendererOptions {
        max_instances: crowd.instances.len() as u32,
        max_vertices: held(needs.vertices),
        max_triangles: held(needs.triangles),
        color_format,
        sample_count,
    };
    options.clamped_to(&device.limits())
}

/// Upper bounds of what a frame may select.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Needs {
    vertices: u64,
    triangles: u64,
}

impl Needs {
    fn of(data: &CrowdData, instances: &[InstanceRecord], largest_budget: u32) -> Self {
        let (mut full, mut least, mut full_triangles) = (0u64, 0u64, 0u64);
        for one in instances {
            let character = &data.characters[one.character as usize];
            full += u64::from(character.vertex_count);
            least += u64::from(character.min_vertex_count);
            full_triangles += u64::from(character.triangle_count);
        }
        let vertices = u64::from(largest_budget).max(least).min(full);
        let ratio = data.lods.iter().filter(|l| l.vertex_count > 0).map(triangles_a_vertex).fold(1.0, f64::max);
        // One more triangle an instance for the rounding.
        let triangles = ((vertices as f64 * ratio) as u64 + instances.len() as u64).min(full_triangles);
        Self { vertices, triangles }
    }
}

fn triangles_a_vertex(lod: &crowd_pack::LodRecord) -> f64 {
    f64::from(lod.triangle_count) / f64::from(lod.vertex_count)
}

/// Samples of a picture: two gigabytes of colour and depth.
const MOST_SAMPLES: u64 = 1 << 28;

/// Refuses pictures the device has no texture for, and those of more than 2^28 samples.
pub fn check_size(device: &wgpu::Device, size: [u32; 2], samples: u32) -> Result<()> {
    let refused = |found: String, allowed: String| Err(Error::Parameter { option: "--size", found, allowed });
    let [width, height] = size;
    let longest = device.limits().max_texture_dimension_2d;
    if width.max(height) > longest {
        return refused(format!("{width}x{height}"), format!("up to {longest} pixels a side on this adapter"));
    }
    if u64::from(width) * u64::from(height) * u64::from(samples) > MOST_SAMPLES {
        let fewer = if samples > 1 { "; more with --msaa 1" } else { "" };
        return refused(
            format!("{width}x{height} with {samples} sample(s) a pixel"),
            format!("up to {} pixels{fewer}", MOST_SAMPLES / u64::from(samples.max(1))),
        );
    }
    Ok(())
}

/// Waits for everything submitted.
pub fn wait(device: &wgpu::Device) -> Result<()> {
    device.poll(wgpu::PollType::wait_indefinitely()).map(|_| ()).map_err(|e| Error::Machine {
        what: format!("the GPU stopped: {e}"),
        remedy: "try fewer instances, or --backend cpu",
    })
}

/// A texture to draw into and read back.
#[derive(Debug)]
pub struct Canvas {
    texture: wgpu::Texture,
    /// What to draw into.
    pub view: wgpu::TextureView,
    /// Pixels.
    pub size: [u32; 2],
    format: wgpu::TextureFormat,
}

impl Canvas {
    /// `format`: an eight-bit RGBA or BGRA one.
    ///
    /// # Errors
    /// [`crowd_stages::Error::OutOfMemory`] when the device has no room for it.
    pub fn new(device: &wgpu::Device, size: [u32; 2], format: wgpu::TextureFormat) -> Result<Self> {
        let bytes = u64::from(size[0]) * u64::from(size[1]) * 4;
        let texture = texture_or_error(
            device,
            "picture",
            bytes,
            "ask for a smaller picture",
            &wgpu::TextureDescriptor {
                label: Some("canvas"),
                size: wgpu::Extent3d { width: size[0], height: size[1], depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
                view_formats: &[],
            },
        )?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { texture, view, size, format })
    }

    /// Copies the pixels out; waits.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Picture> {
        let [width, height] = self.size;
        let row_bytes = (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let descriptor = wgpu::BufferDescriptor {
            label: Some("canvas read-back"),
            size: u64::from(row_bytes) * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        };
        let buffer = buffer_or_error(device, "picture read back", "ask for a smaller picture", &descriptor)?;
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("read back") });
        let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
        let into = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
        encoder.copy_texture_to_buffer(self.texture.as_image_copy(), into, self.texture.size());
        queue.submit([encoder.finish()]);
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver lives until the wait below is over.
            let _ = sender.send(result);
        });
        wait(device)?;
        let lost = |problem: String| Error::Machine {
            what: format!("the picture could not be read back: {problem}"),
            remedy: "try a smaller --size, or --backend cpu",
        };
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(e)) => return Err(lost(e.to_string())),
            Err(e) => return Err(lost(e.to_string())),
        }
        let bytes = buffer.get_mapped_range(..).map_err(|e| lost(e.to_string()))?;
        let swap = matches!(self.format, wgpu::TextureFormat::Bgra8Unorm | wgpu::TextureFormat::Bgra8UnormSrgb);
        let mut pixels = Vec::with_capacity(width as usize * height as usize);
        for row in bytes.chunks_exact(row_bytes as usize) {
            let (texels, _) = row[..4 * width as usize].as_chunks::<4>();
            pixels.extend(texels.iter().map(|&[a, b, c, d]| if swap { [c, b, a, d] } else { [a, b, c, d] }));
        }
        Ok(Picture { width, height, pixels })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_pack::{CharacterRecord, LodRecord};

    #[test]
    fn room_for_every_frame() {
        let lod = |vertex_count, triangle_count| LodRecord { vertex_count, triangle_count };
        let character =
            CharacterRecord { vertex_count: 100, triangle_count: 150, min_vertex_count: 10, ..Default::default() };
        let data = CrowdData {
            characters: vec![character],
            lods: vec![lod(0, 0), lod(10, 18), lod(100, 150)],
            ..Default::default()
        };
        let instances = vec![InstanceRecord::default(); 10];
        assert_eq!(Needs::of(&data, &instances, 5_000), Needs { vertices: 1000, triangles: 1500 });
        assert_eq!(Needs::of(&data, &instances, 200), Needs { vertices: 200, triangles: 370 });
        assert_eq!(Needs::of(&data, &instances, 1).vertices, 100, "the coarsest levels are drawn whatever the budget");
    }
}
