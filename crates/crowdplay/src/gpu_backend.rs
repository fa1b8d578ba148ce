//! Frames drawn by the GPU into a texture, and read back.

use crate::crowd::Crowd;
use crate::gpu_device::Gpu;
use crate::memory::{Beside, CrowdNeeds, Parts, Room};
use crate::picture::Picture;
use crate::plan::DetailPlan;
use crate::scenery::Scenery;
use crate::schedules::Schedules;
use crate::simulation::Simulation;
use crate::{Error, Result};
use crowd_stages::gpu::{
    CrowdRenderer, RendererOptions, SkinningChoice, buffer_or_error, poll_device, texture_or_error,
};
use crowd_stages::{BudgetIn, DrawOptions, FrameConfig, FrameTotals, InstanceRecord, Technique};
use std::time::Instant;

/// A renderer that draws into a texture of its own.
pub struct GpuBackend {
    gpu: Gpu,
    renderer: CrowdRenderer,
    simulation: Option<Simulation>,
    canvas: Canvas,
    samples: u32,
    /// The reference camera has been or will be looked through.
    has_reference: bool,
    /// What recording and submitting the newest frame took.
    cpu_ms: f32,
    /// Why N is no larger, see [`Room::remark`].
    room_remark: Option<String>,
}

impl GpuBackend {
    /// Uploads the crowd. `largest_budget`: the largest N that will be asked for, and what it counts.
    pub fn new(
        gpu: Gpu,
        crowd: &Crowd,
        size: [u32; 2],
        samples: u32,
        (largest_budget, budget_in): (u32, BudgetIn),
    ) -> Result<Self> {
        check_size(&gpu.device, size, samples)?;
        let format = wgpu::TextureFormat::Rgba8UnormSrgb;
        let options = renderer_options(&gpu.device, crowd, format, samples, largest_budget, budget_in);
        let mut renderer = CrowdRenderer::new(&gpu.device, &gpu.queue, &crowd.data, options)?;
        renderer.set_instances(&gpu.queue, &crowd.instances)?;
        renderer.set_motion(&gpu.device, &gpu.queue, crowd.schedules.as_ref().map(Schedules::plan))?;
        let Scenery { vertices, triangles } = &crowd.scenery;
        renderer.set_scenery(&gpu.device, &gpu.queue, vertices, triangles)?;
        let canvas = Canvas::new(&gpu.device, size, format)?;
        let simulation = Simulation::of(&gpu, &mut renderer, crowd)?;
        let (cpu_ms, room_remark) = (0.0, None);
        Ok(Self { gpu, renderer, simulation, canvas, samples, has_reference: false, cpu_ms, room_remark })
    }

    /// Other instances than before, at most as many as the crowd had first.
    pub fn set_instances(&mut self, instances: &[InstanceRecord]) -> Result<()> {
        Ok(self.renderer.set_instances(&self.gpu.queue, instances)?)
    }

    /// The crowd's own instances again, and what they play: other instances in between have ended that.
    pub fn set_crowd(&mut self, crowd: &Crowd) -> Result<()> {
        let Self { gpu, renderer, .. } = self;
        renderer.set_instances(&gpu.queue, &crowd.instances)?;
        Ok(renderer.set_motion(&gpu.device, &gpu.queue, crowd.schedules.as_ref().map(Schedules::plan))?)
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
        gpu.loss.expect_none()?;
        let start = Instant::now();
        let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("frame") });
        let size = (canvas.size[0], canvas.size[1]);
        renderer.encode(&gpu.device, &gpu.queue, &mut encoder, &canvas.view, size, config, options)?;
        gpu.queue.submit([encoder.finish()]);
        self.cpu_ms = start.elapsed().as_secs_f32() * 1e3;
        // Where the queue did not take it, there is nothing to wait for.
        gpu.loss.expect_none()?;
        wait(&gpu.device)?;
        let totals = renderer.totals(&gpu.device, true).unwrap_or_default();
        gpu.loss.expect_none()?;
        gpu.loss.count_frame();
        Ok(totals)
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
        self.has_reference = true;
        let Self { gpu, renderer, canvas, .. } = self;
        draw_reference(gpu, renderer, canvas.size, canvas.format, configs, options)
    }

    /// GPU milliseconds by stage of the newest frame.
    pub fn timings_ms(&mut self) -> Vec<(&'static str, f32)> {
        self.renderer.timings_ms()
    }

    /// What the CPU did for the newest frame, milliseconds: recording and submitting it.
    pub fn cpu_ms(&self) -> f32 {
        self.cpu_ms
    }

    /// Vertex shader runs of the newest frame's crowd, where the adapter counts them.
    pub fn vertex_runs(&mut self) -> Option<u64> {
        self.renderer.vertex_runs()
    }

    /// Poses that were worked out in the newest frame, where they are shared.
    pub fn shared_poses(&mut self) -> Result<Option<u32>> {
        Ok(self.renderer.shared_poses(&self.gpu.device, &self.gpu.queue)?)
    }

    /// How high the water was in the newest frame.
    pub fn water_bits(&mut self) -> Result<u32> {
        Ok(self.renderer.water_bits(&self.gpu.device, &self.gpu.queue)?)
    }

    /// The picture that is drawn into and the one that the reference camera's is drawn into: never more, mostly less.
    fn beside(&self) -> Beside {
        let simulator_bytes = self.simulation.as_ref().map(Simulation::gpu_bytes);
        Beside { canvases: 1 + u64::from(self.has_reference), simulator_bytes }
    }

    /// Makes room for the largest budget that fits so many bytes beside everything else that `draws` need, or for `budget`; with
    /// `has_reference` beside a second picture for the reference camera.
    ///
    /// # Errors
    /// [`Error::Memory`] when that, or the least budget, does not fit.
    pub fn fit_memory(
        &mut self,
        crowd: &Crowd,
        detail: &DetailPlan,
        limit_bytes: u64,
        (draws, has_reference): (Vec<DrawOptions>, bool),
        budget: Option<u32>,
    ) -> Result<u32> {
        self.has_reference = has_reference;
        let beside = self.beside();
        let Self { gpu, renderer, canvas, samples, .. } = self;
        if has_reference {
            renderer.prepare_marks(&gpu.device, &gpu.queue)?;
        }
        let room = Room::new(limit_bytes, crowd, detail, draws, beside, (canvas.format, *samples));
        let found = room.fit(gpu, renderer, canvas.size, budget)?;
        let is_searched = budget.is_none();
        self.room_remark = is_searched.then(|| room.remark(gpu, renderer, canvas.size, found)).flatten();
        Ok(found)
    }

    /// Why the largest budget that fits is no larger, where that is not for want of the memory allowed.
    pub fn room_remark(&self) -> Option<&str> {
        self.room_remark.as_deref()
    }

    /// Bytes of GPU memory by what they are for.
    pub fn memory(&self) -> Parts {
        self.beside().with(&self.renderer.memory(), self.canvas.size)
    }

    /// All of it.
    pub fn gpu_bytes(&self) -> u64 {
        self.memory().iter().map(|(_, bytes)| bytes).sum()
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
    budget_in: BudgetIn,
) -> RendererOptions {
    let needs = CrowdNeeds::of(&crowd.data, &crowd.instances, budget_in);
    needs.options(device, color_format, sample_count, largest_budget)
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
            format!("{width}x{height} with --msaa {samples}"),
            format!("up to {} pixels{fewer}", MOST_SAMPLES / u64::from(samples.max(1))),
        );
    }
    Ok(())
}

/// Waits for everything submitted.
pub fn wait(device: &wgpu::Device) -> Result<()> {
    poll_device(device, wgpu::PollType::wait_indefinitely())?;
    Ok(())
}

/// Bytes of a canvas of so many pixels: of the texture, and of the buffer that its pixels are read back through.
pub fn canvas_bytes([width, height]: [u32; 2]) -> u64 {
    (4 * u64::from(width) + u64::from(row_bytes(width))) * u64::from(height)
}

fn row_bytes(width: u32) -> u32 {
    (4 * width).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT)
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
        Self::seen_as(device, size, format, &[])
    }

    /// The same, that may also be seen in other formats.
    ///
    /// # Errors
    /// [`crowd_stages::Error::OutOfMemory`] when the device has no room for it.
    pub fn seen_as(
        device: &wgpu::Device,
        size: [u32; 2],
        format: wgpu::TextureFormat,
        view_formats: &[wgpu::TextureFormat],
    ) -> Result<Self> {
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
                view_formats,
            },
        )?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self { texture, view, size, format })
    }

    /// What is drawn into.
    pub fn texture(&self) -> &wgpu::Texture {
        &self.texture
    }

    /// Copies the pixels out; waits.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> Result<Picture> {
        let [width, height] = self.size;
        let row_bytes = row_bytes(width);
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
