//! Pictures in the window, and pictures of it.

use super::running::{Painter, Running};
use crate::Result;
use crate::Talk;
use crate::camera_control::CameraControl;
use crate::crowd::Crowd;
use crate::gpu_backend::{Canvas, bake_frame};
use crate::overlay::{self, Knobs, Readings, Shot};
use crate::picture::{Picture, write_file};
use crate::surface::Screen;
use crate::view::frame_config;
use crowd_stages::{FrameConfig, FrameTotals};
use std::path::{Path, PathBuf};

impl Running {
    /// The crowd, or all of the window, under the first free name in the current folder. A failure is shown, not fatal.
    pub(super) fn save_picture(&mut self, crowd: &Crowd, config: &FrameConfig, shot: Shot, talk: &mut Talk<'_>) {
        let file = free_name();
        let taken = match shot {
            Shot::Crowd => self.take_picture(crowd, config),
            Shot::Window => self.take_window(crowd, config),
        };
        let written = taken.and_then(|picture| write_file(&file, &picture.to_png()));
        let message = match written {
            Ok(()) => format!("wrote {}", file.display()),
            Err(error) => error.to_string(),
        };
        talk.say(&message);
        self.readings.message = Some(message);
    }

    /// Writes a picture of the window as it is, drawn once more.
    ///
    /// # Errors
    /// [`crate::Error::Output`] when it cannot be written.
    pub(super) fn save_window(&mut self, crowd: &Crowd, file: &Path, talk: &mut Talk<'_>) -> Result<()> {
        let (camera, detail) = (self.control.camera(), self.detail());
        let config = frame_config(&camera, self.screen.size(), self.readings.time_s, &detail, self.knobs.budget);
        let picture = self.take_window(crowd, &config)?;
        write_file(file, &picture.to_png())?;
        talk.say(&format!("wrote {}", file.display()));
        Ok(())
    }

    /// All that the window shows.
    fn take_window(&mut self, crowd: &Crowd, config: &FrameConfig) -> Result<Picture> {
        self.has_canvas = true;
        let Self { screen, gpu, painter, simulation, corner, knobs, readings, control, .. } = self;
        let output = lay_out(screen, painter, corner.as_ref(), knobs, readings, control);
        if let Painter::Gpu(renderer) = painter {
            bake_frame(gpu, renderer, simulation.as_ref(), crowd, config, knobs.draw)?;
        }
        let (size, draw) = (screen.size(), knobs.draw);
        screen.picture(gpu, output, |encoder, view| {
            if let Painter::Gpu(renderer) = painter {
                renderer.encode(&gpu.device, &gpu.queue, encoder, view, (size[0], size[1]), config, draw)?;
            }
            Ok(())
        })
    }

    fn take_picture(&mut self, crowd: &Crowd, config: &FrameConfig) -> Result<Picture> {
        let Self { screen, gpu, painter, simulation, knobs, .. } = self;
        match painter {
            Painter::Cpu(cpu, _) => {
                cpu.resize(screen.size());
                let _: FrameTotals = cpu.draw(crowd, config, knobs.draw, &mut |_| {});
                Ok(cpu.picture())
            }
            Painter::Gpu(renderer) => {
                bake_frame(gpu, renderer, simulation.as_ref(), crowd, config, knobs.draw)?;
                self.has_canvas = true;
                let canvas = Canvas::new(&gpu.device, screen.size(), screen.scene_format())?;
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let size = (canvas.size[0], canvas.size[1]);
                renderer.encode(&gpu.device, &gpu.queue, &mut encoder, &canvas.view, size, config, knobs.draw)?;
                gpu.queue.submit([encoder.finish()]);
                canvas.read(&gpu.device, &gpu.queue)
            }
        }
    }
}

/// Lays out what lies over the crowd: what the CPU drew, the second camera's corner, the overlay.
pub(super) fn lay_out(
    screen: &mut Screen,
    painter: &Painter,
    corner: Option<&egui::TextureHandle>,
    knobs: &mut Knobs,
    readings: &Readings,
    control: &CameraControl,
) -> egui::FullOutput {
    let behind = if let Painter::Cpu(_, Some(image)) = painter { Some(image.id()) } else { None };
    screen.run_overlay(|ui| {
        if let Some(image) = behind {
            let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
            let area = ui.ctx().content_rect();
            ui.ctx().layer_painter(egui::LayerId::background()).image(image, area, whole, egui::Color32::WHITE);
        }
        if let Some(image) = corner {
            paint_corner(ui, image);
        }
        overlay::show(ui, knobs, readings, control);
    })
}

/// The second camera's picture, pixel for pixel, in the lower right corner.
fn paint_corner(ui: &egui::Ui, image: &egui::TextureHandle) {
    let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
    let size = image.size_vec2() / ui.ctx().pixels_per_point();
    let area = egui::Rect::from_min_size(ui.ctx().content_rect().max - size - egui::vec2(6.0, 6.0), size);
    let painter = ui.ctx().layer_painter(egui::LayerId::background());
    painter.rect_filled(area.expand(2.0), 0.0, egui::Color32::from_gray(245));
    painter.image(image.id(), area, whole, egui::Color32::WHITE);
}

pub(super) fn show_image(egui: &egui::Context, image: &mut Option<egui::TextureHandle>, picture: &Picture) {
    let pixels: Vec<u8> = picture.pixels.iter().flat_map(|&[r, g, b, _]| [r, g, b]).collect();
    let color = egui::ColorImage::from_rgb([picture.width as usize, picture.height as usize], &pixels);
    match image {
        Some(handle) => handle.set(color, egui::TextureOptions::NEAREST),
        None => *image = Some(egui.load_texture("cpu picture", color, egui::TextureOptions::NEAREST)),
    }
}

/// `crowdplay-0001.png` and up.
fn free_name() -> PathBuf {
    let name = |i: u32| PathBuf::from(format!("crowdplay-{i:04}.png"));
    (1..10_000).map(name).find(|file| !file.exists()).unwrap_or_else(|| name(10_000))
}
