//! What exists while the window is open, and how a frame of it is drawn.

use super::REMEDY;
use super::shots::{lay_out, show_image};
use crate::backend;
use crate::camera_control::{CameraControl, Held};
use crate::cli::{BackendWord, PoseRates};
use crate::cpu_backend::CpuBackend;
use crate::crowd::Crowd;
use crate::governor::Governor;
use crate::gpu_backend::{bake_frame, draw_reference, renderer_options};
use crate::gpu_device::{self, Gpu};
use crate::headless::report;
use crate::memory::{Beside, Parts, Room, check_count};
use crate::overlay::{Knobs, Readings};
use crate::plan::{DetailPlan, MachinePlan, Plan, WindowPlan};
use crate::schedules::Schedules;
use crate::simulation::Simulation;
use crate::stats::{Frame, Report, Timings};
use crate::surface::Screen;
use crate::view::{self, Viewer, frame_config};
use crate::{Error, Result, Talk};
use crowd_stages::gpu::CrowdRenderer;
use crowd_stages::{BudgetIn, DrawOptions, FrameConfig, SkinnedVertex};
use std::sync::Arc;
use std::time::Instant;
use winit::event::MouseButton;
use winit::event_loop::ActiveEventLoop;
use winit::keyboard::KeyCode;
use winit::window::Window;

/// What draws into the window.
pub(super) enum Painter {
    Gpu(Box<CrowdRenderer>),
    /// Drawn on the CPU, shown as an image behind the overlay.
    Cpu(Box<CpuBackend>, Option<egui::TextureHandle>),
}

/// All that exists while the window is open.
pub(super) struct Running {
    pub(super) screen: Screen,
    pub(super) gpu: Gpu,
    pub(super) painter: Painter,
    pub(super) simulation: Option<Simulation>,
    /// Memory that may be taken.
    pub(super) room: Option<Room>,
    /// A picture of the frame's size was made: a screenshot, or what the reference camera sees.
    pub(super) has_canvas: bool,
    /// How the frame before was drawn.
    pub(super) drawn: DrawOptions,
    /// Size of that frame.
    pub(super) drawn_size: [u32; 2],
    /// What its budget counted.
    pub(super) counted_in: BudgetIn,
    /// What the second camera saw of the frame before, in the corner.
    pub(super) corner: Option<egui::TextureHandle>,
    pub(super) samples: u32,
    pub(super) pose_rates: PoseRates,
    pub(super) lod_depths_m: Option<[f32; 2]>,
    pub(super) knobs: Knobs,
    /// Of the knobs, as the painter has it.
    pub(super) motion: Option<bool>,
    /// With the budget that it gave last.
    pub(super) governor: Option<(Governor, u32)>,
    pub(super) readings: Readings,
    pub(super) control: CameraControl,
    /// The camera path is followed until the user takes over.
    pub(super) on_path: bool,
    pub(super) keys: Vec<KeyCode>,
    pub(super) buttons: Vec<MouseButton>,
    pub(super) pointer: Option<(f64, f64)>,
    pub(super) last_frame: Instant,
    pub(super) frame_count: u32,
    /// Kept only when a report is wanted.
    pub(super) frames: Option<Vec<Frame>>,
    /// Where the camera was by the window's clock, kept only when that is wanted.
    pub(super) recording: Option<crowd_scene::CameraPath>,
    pub(super) records: bool,
    pub(super) shown_s: f32,
}

impl Running {
    /// Opens the GPU and sets up what draws.
    pub(super) fn new(
        plan: &Plan,
        shown: &WindowPlan,
        crowd: &Crowd,
        viewer: &Viewer,
        window: Arc<Window>,
        event_loop: &ActiveEventLoop,
        talk: &mut Talk<'_>,
    ) -> Result<Self> {
        let machine = MachinePlan { backend: BackendWord::Auto, ..plan.machine.clone() };
        let open = |backends: wgpu::Backends| -> Result<(Gpu, wgpu::Surface<'static>)> {
            let display = Box::new(event_loop.owned_display_handle());
            let mut descriptor = wgpu::InstanceDescriptor::new_with_display_handle_from_env(display);
            descriptor.backends = backends.with_env();
            let instance = wgpu::Instance::new(descriptor);
            let surface = instance
                .create_surface(window.clone())
                .map_err(|e| Error::Machine { what: format!("no surface: {e}"), remedy: REMEDY })?;
            Ok((gpu_device::open(&instance, &machine, Some(&surface))?, surface))
        };
        let [first, last] = gpu_device::BACKENDS;
        let (gpu, surface) = open(first).or_else(|error| open(last).map_err(|_| error))?;
        talk.say(&gpu.line());
        let screen = Screen::new(&gpu, surface, window)?;

        let on_cpu = plan.machine.backend == BackendWord::Cpu;
        let detail = backend::settle_technique(&plan.detail, (!on_cpu).then_some(&gpu), talk);
        let mut budget =
            detail.budget.unwrap_or_else(|| backend::usual_budget((!on_cpu).then_some(&gpu), crowd, &detail));
        let mut largest_budget = budget.max(backend::largest_budget(crowd, detail.budget_in));
        let is_software = on_cpu || gpu.is_software();
        let samples = plan.machine.samples.unwrap_or(if is_software { 1 } else { 4 });
        let (mut simulation, mut room) = (None, None);
        let painter = if on_cpu {
            Painter::Cpu(Box::new(CpuBackend::new(crowd, screen.size(), samples)?), None)
        } else {
            let format = screen.scene_format();
            // A slider that goes beyond what can be skinned beforehand would take the shaders that need not ask who is from all smaller budgets.
            let binding = gpu.device.limits().max_storage_buffer_binding_size;
            let skinnable = u32::try_from(binding / size_of::<SkinnedVertex>() as u64).unwrap_or(u32::MAX);
            if detail.budget_in == BudgetIn::Vertices && budget <= skinnable {
                largest_budget = largest_budget.min(skinnable);
            }
            check_count(&gpu.device, crowd.instances.len(), &[detail.draw])?;
            let options = renderer_options(&gpu.device, crowd, format, samples, largest_budget, detail.budget_in);
            largest_budget = largest_budget.min(match detail.budget_in {
                BudgetIn::Vertices => options.max_vertices,
                BudgetIn::Triangles => options.max_triangles,
            });
            let mut renderer = CrowdRenderer::new(&gpu.device, &gpu.queue, &crowd.data, options)?;
            renderer.set_instances(&gpu.queue, &crowd.instances)?;
            renderer.set_motion(&gpu.device, &gpu.queue, crowd.schedules.as_ref().map(Schedules::plan))?;
            renderer.set_scenery(&gpu.device, &gpu.queue, &crowd.scenery.vertices, &crowd.scenery.triangles)?;
            simulation = Simulation::of(&gpu, &mut renderer, crowd)?;
            if let Some(limit_bytes) = plan.machine.vram_bytes {
                // A screenshot, or what the reference camera sees: one at a time. Keys ask for both.
                renderer.prepare_marks(&gpu.device, &gpu.queue)?;
                let simulator_bytes = simulation.as_ref().map(Simulation::gpu_bytes);
                let beside = Beside { canvases: 1, simulator_bytes };
                let kept = Room::new(limit_bytes, crowd, &detail, vec![detail.draw], beside, (format, samples));
                if let Some(asked) = detail.budget.filter(|_| detail.target_ms.is_none()) {
                    kept.fit(&gpu, &mut renderer, screen.size(), Some(asked))?;
                }
                // Sliders and a target rise to what fits.
                let fitting = kept.fit(&gpu, &mut renderer, screen.size(), None)?;
                if fitting > largest_budget {
                    kept.fit(&gpu, &mut renderer, screen.size(), Some(largest_budget))?;
                }
                largest_budget = fitting.min(largest_budget);
                let begins_there = detail.budget.is_some() || detail.target_ms.is_some();
                budget = if begins_there { budget.min(largest_budget) } else { largest_budget };
                room = Some(kept);
            }
            renderer.prepare(&gpu.device, &gpu.queue, detail.draw.technique)?;
            Painter::Gpu(Box::new(renderer))
        };
        let readings = Readings {
            adapter: if on_cpu { "CPU (crowd-raster)".to_owned() } else { gpu.info.name.clone() },
            on_gpu: !on_cpu,
            has_impostors: crowd.data.impostors.is_some(),
            time_s: shown.start_s,
            instances: crowd.summary.instances,
            triangles_full: crowd.summary.triangles_full,
            vram_bytes: plan.machine.vram_bytes.filter(|_| !on_cpu),
            ..Readings::default()
        };
        let knobs = Knobs {
            budget,
            budget_in: detail.budget_in,
            steady_percent: 100.0 * detail.slack_share,
            largest_budget,
            target_ms: detail.target_ms,
            alpha: detail.alpha,
            weight: detail.weight,
            draw: detail.draw,
            max_px: detail.max_px,
            impostors_px: detail.impostors_px,
            dots_px: detail.dots_px,
            sight_m: detail.sight_m,
            motion: crowd.schedules.as_ref().map(|_| true),
            can_hold: !crowd.data.clip_speeds.is_empty(),
            paused: shown.time_scale == 0.0,
            time_scale: if shown.time_scale > 0.0 { shown.time_scale } else { 1.0 },
            visible: shown.overlay,
            reference: plan.reference_camera && !on_cpu,
            shot: None,
        };
        let drawn_size = screen.size();
        let mut running = Self {
            screen,
            gpu,
            painter,
            simulation,
            drawn: knobs.draw,
            drawn_size,
            counted_in: knobs.counts(),
            room,
            has_canvas: false,
            corner: None,
            samples,
            pose_rates: plan.detail.pose_rates,
            lod_depths_m: plan.detail.lod_depths_m,
            motion: knobs.motion,
            knobs,
            governor: None,
            readings,
            control: CameraControl::new(viewer.at(shown.start_s)),
            on_path: matches!(viewer, Viewer::Path(..)),
            keys: Vec::new(),
            buttons: Vec::new(),
            pointer: None,
            last_frame: Instant::now(),
            frame_count: 0,
            frames: plan.report.is_some().then(Vec::new),
            recording: None,
            records: plan.record_camera.is_some(),
            shown_s: 0.0,
        };
        running.count_memory();
        Ok(running)
    }

    /// Bytes of GPU memory by what they are for; none on the CPU.
    fn memory(&self) -> Parts {
        let Painter::Gpu(renderer) = &self.painter else { return Parts::new() };
        let simulator_bytes = self.simulation.as_ref().map(Simulation::gpu_bytes);
        Beside { canvases: self.has_canvas.into(), simulator_bytes }.with(&renderer.memory(), self.screen.size())
    }

    fn count_memory(&mut self) {
        self.readings.gpu_bytes = self.memory().iter().map(|(_, bytes)| bytes).sum();
    }

    /// Draws a frame: time, camera, crowd, budget, picture.
    pub(super) fn redraw(&mut self, crowd: &mut Crowd, viewer: &Viewer, talk: &mut Talk<'_>) -> Result<()> {
        let now = Instant::now();
        let dt_s = (now - self.last_frame).as_secs_f32();
        self.last_frame = now;
        self.readings.push_frame_ms(dt_s * 1e3);
        if !self.knobs.paused {
            // A long frame does not make everybody leap.
            self.readings.time_s += dt_s.min(0.25) * self.knobs.time_scale;
        }
        let held = self.held();
        self.on_path &= held == Held { fast: held.fast, ..Held::default() };
        self.control.advance(held, dt_s.min(0.25));
        if self.on_path {
            self.control.stand_at(viewer.at(self.readings.time_s));
        }
        if let Some(simulation) = &mut self.simulation {
            simulation.advance(&self.gpu, self.readings.time_s);
        } else if crowd.advance(self.readings.time_s) {
            self.readings.instances = crowd.instances.len() as u32;
            self.readings.triangles_full = crowd.present_triangles();
            if let Painter::Gpu(renderer) = &mut self.painter {
                renderer.set_instances(&self.gpu.queue, &crowd.instances)?;
            }
        }
        self.recount(crowd);
        self.keep_within_memory();
        self.play_motion(crowd)?;
        let detail = self.detail();
        let camera = self.control.camera();
        if self.records {
            view::record(&mut self.recording, self.shown_s, &camera);
            self.shown_s += dt_s;
        }
        let config = frame_config(&camera, self.screen.size(), self.readings.time_s, &detail, self.knobs.budget);
        if let Some(shot) = self.knobs.shot.take() {
            self.save_picture(crowd, &config, shot, talk);
        }
        let budget = self.knobs.budget;
        self.draw(crowd, &config)?;
        self.show_reference(crowd, &camera, &config, &detail)?;
        self.frame_count += 1;
        self.govern(dt_s * 1e3);
        if let Some(frames) = &mut self.frames {
            let Readings { totals, time_s, stages_ms, .. } = &self.readings;
            let frame = Frame::new(self.frame_count - 1, *time_s, budget, *totals, dt_s * 1e3, stages_ms);
            frames.push(frame.of(crowd));
        }
        Ok(())
    }

    /// The knobs as a plan.
    pub(super) fn detail(&self) -> DetailPlan {
        let Knobs {
            budget,
            steady_percent,
            alpha,
            weight,
            draw,
            max_px,
            dots_px,
            impostors_px,
            sight_m,
            target_ms,
            ..
        } = self.knobs;
        DetailPlan {
            budget: Some(budget),
            budget_in: self.knobs.counts(),
            // Eq. 1 as printed has no water that could stay.
            slack_share: if self.knobs.has_water() { steady_percent / 100.0 } else { 0.0 },
            alpha,
            weight,
            draw,
            max_px,
            dots_px,
            sight_m,
            impostors_px,
            target_ms,
            pose_rates: self.pose_rates,
            lod_depths_m: self.lod_depths_m,
            technique_is_given: true,
        }
    }

    /// Draws the crowd and the overlay over it.
    fn draw(&mut self, crowd: &Crowd, config: &FrameConfig) -> Result<()> {
        let Self { screen, gpu, painter, simulation, corner, knobs, readings, control, .. } = self;
        if let Painter::Cpu(cpu, image) = painter {
            cpu.resize(screen.size());
            readings.totals = cpu.draw(crowd, config, knobs.draw, &mut |_| {});
            readings.stages_ms = cpu.timings_ms();
            show_image(&screen.egui, image, &cpu.picture());
        }
        let output = lay_out(screen, painter, corner.as_ref(), knobs, readings, control);
        let size = screen.size();
        if let Painter::Gpu(renderer) = painter {
            bake_frame(gpu, renderer, simulation.as_ref(), crowd, config, knobs.draw)?;
        }
        let drawn = screen.present(gpu, output, |encoder, view| {
            if let Painter::Gpu(renderer) = painter {
                let size = (size[0], size[1]);
                renderer.encode(&gpu.device, &gpu.queue, encoder, view, size, config, knobs.draw)?;
            }
            Ok(())
        })?;
        if drawn {
            gpu.loss.count_frame();
        }
        if let Painter::Gpu(renderer) = painter
            && drawn
        {
            readings.totals = renderer.totals(&gpu.device, false).unwrap_or(readings.totals);
            readings.stages_ms = renderer.timings_ms();
            readings.vertex_runs = renderer.vertex_runs();
            readings.skinning = Some(renderer.skinning(knobs.draw.skinning));
            self.count_memory();
        }
        Ok(())
    }

    /// Draws what the second camera sees; the next frame shows it.
    fn show_reference(
        &mut self,
        crowd: &Crowd,
        camera: &crowd_scene::Camera,
        config: &FrameConfig,
        detail: &DetailPlan,
    ) -> Result<()> {
        let Self { screen, gpu, painter, knobs, corner, has_canvas, .. } = self;
        let Painter::Gpu(renderer) = painter else { return Ok(()) };
        if !knobs.reference || !knobs.can_show_reference() {
            *corner = None;
            return Ok(());
        }
        let size = screen.size();
        let other = view::reference_camera(crowd, camera, size[0] as f32 / size[1].max(1) as f32);
        *has_canvas = true;
        let other = frame_config(&other, size, config.time_s, detail, config.budget);
        match draw_reference(gpu, renderer, size, screen.scene_format(), [config, &other], knobs.draw) {
            Ok(picture) => show_image(&screen.egui, corner, &picture.reduced()),
            // A window that is hidden draws no frame that could be seen from elsewhere.
            Err(Error::Stages(crowd_stages::Error::NoFrame { .. })) => *corner = None,
            Err(error) => return Err(error),
        }
        Ok(())
    }

    /// What it all came to.
    pub(super) fn into_report(self, plan: &Plan, crowd: &Crowd) -> Report {
        let (word, adapter) = match &self.painter {
            Painter::Gpu(_) => ("gpu", self.gpu.describe()),
            Painter::Cpu(..) => ("cpu", backend::cpu_adapter()),
        };
        let mut report = report(plan, &self.detail(), crowd, self.knobs.budget, word, adapter);
        if let Some(choice) = &self.readings.skinning {
            report.skinning = choice.way.name();
            report.skinning_ms = choice.measured_ms;
        }
        let has_flock = crowd.moving.as_ref().is_some_and(|moving| moving.flock().is_some());
        report.simulator = has_flock.then_some(if self.simulation.is_some() { "gpu" } else { "cpu" });
        report.size = self.screen.size();
        report.samples = self.samples;
        report.set_memory(&self.memory());
        report.frames = self.frames.unwrap_or_default();
        report.timings = Timings::of(&report.frames);
        report
    }
}
