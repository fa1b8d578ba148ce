//! The window: an event loop around the renderer, a camera one can steer, and the overlay.

use crate::backend;
use crate::camera_control::{CameraControl, Held};
use crate::cli::{BackendWord, PoseRates};
use crate::cpu_backend::CpuBackend;
use crate::crowd::Crowd;
use crate::governor::Governor;
use crate::gpu_backend::{Canvas, bake_frame, draw_reference, renderer_options};
use crate::gpu_device::{self, Gpu};
use crate::headless::{report, write_recording};
use crate::memory::Room;
use crate::overlay::{self, Knobs, Readings};
use crate::picture::{Picture, write_file};
use crate::plan::{DetailPlan, MachinePlan, Plan};
use crate::schedules::Schedules;
use crate::simulation::Simulation;
use crate::stats::{Frame, Report, Timings};
use crate::surface::Screen;
use crate::view::{self, Viewer, frame_config};
use crate::{Error, Result, Talk};
use crowd_stages::gpu::CrowdRenderer;
use crowd_stages::{BudgetIn, DrawOptions, FrameConfig, FrameTotals, Technique};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::keyboard::{KeyCode, PhysicalKey};
use winit::window::{Window, WindowId};

const REMEDY: &str = "use --headless --out picture.png to draw without a window";

/// Opens the window and runs until it is closed, or for `frames` frames.
///
/// # Errors
/// [`Error::Machine`] without a display, or without a GPU that can draw to it.
pub fn show(plan: &Plan, frames: Option<u32>, crowd: Crowd, talk: &mut Talk<'_>) -> Result<Report> {
    let viewer = Viewer::open(&plan.camera, &crowd)?;
    let no_window =
        |e: winit::error::EventLoopError| Error::Machine { what: format!("no window: {e}"), remedy: REMEDY };
    let event_loop = EventLoop::new().map_err(no_window)?;
    event_loop.set_control_flow(ControlFlow::Poll);
    let mut app = App { plan, frames, crowd, viewer, talk, running: None, failure: None };
    event_loop.run_app(&mut app).map_err(no_window)?;
    if let Some(error) = app.failure {
        return Err(error);
    }
    let running = app.running.ok_or_else(|| Error::Machine {
        what: "the window was closed before the first frame".to_owned(),
        remedy: REMEDY,
    })?;
    write_recording(plan, running.recording.as_ref())?;
    Ok(running.into_report(plan, &app.crowd))
}

/// Finds out early, before a pack is read, that there is no display.
///
/// # Errors
/// [`Error::Machine`] with the way to do without.
pub fn expect_display() -> Result<()> {
    let what = "no display: neither DISPLAY nor WAYLAND_DISPLAY is set".to_owned();
    if has_display() { Ok(()) } else { Err(Error::Machine { what, remedy: REMEDY }) }
}

/// Elsewhere than on X11 and Wayland there always is one.
fn has_display() -> bool {
    let unixoid = cfg!(all(unix, not(any(target_os = "macos", target_os = "ios", target_os = "android"))));
    let set = |name| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    !unixoid || ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"].into_iter().any(set)
}

struct App<'a, 'talk> {
    plan: &'a Plan,
    frames: Option<u32>,
    crowd: Crowd,
    viewer: Viewer,
    talk: &'a mut Talk<'talk>,
    running: Option<Running>,
    failure: Option<Error>,
}

impl App<'_, '_> {
    fn start(&mut self, event_loop: &ActiveEventLoop) -> Result<Running> {
        let [width, height] = self.plan.size;
        let attributes = Window::default_attributes()
            .with_title(format!("crowdplay - {}", self.plan.pack.file_name().unwrap_or_default().to_string_lossy()))
            .with_inner_size(winit::dpi::PhysicalSize::new(width, height));
        let window = event_loop
            .create_window(attributes)
            .map_err(|e| Error::Machine { what: format!("no window: {e}"), remedy: REMEDY })?;
        Running::new(self.plan, &self.crowd, &self.viewer, Arc::new(window), event_loop, self.talk)
    }
}

impl ApplicationHandler for App<'_, '_> {
    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.running.is_some() {
            return;
        }
        match self.start(event_loop) {
            Ok(running) => self.running = Some(running),
            Err(error) => {
                self.failure = Some(error);
                event_loop.exit();
            }
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(running) = &mut self.running else { return };
        if event == WindowEvent::RedrawRequested {
            if let Err(error) = running.redraw(&mut self.crowd, &self.viewer, self.talk) {
                self.failure = Some(error);
                event_loop.exit();
            }
            if self.frames.is_some_and(|frames| running.frame_count >= frames) {
                event_loop.exit();
            }
            running.screen.window.request_redraw();
            return;
        }
        // Keys are the camera's unless a number is being typed: Tab and Space must not wander through the sliders.
        let is_key = matches!(event, WindowEvent::KeyboardInput { .. });
        let taken = if is_key && !running.screen.egui.text_edit_focused() {
            false
        } else {
            running.screen.egui_state.on_window_event(&running.screen.window, &event).consumed
        };
        running.handle(&event, taken, event_loop);
    }
}

/// What draws into the window.
enum Painter {
    Gpu(Box<CrowdRenderer>),
    /// Drawn on the CPU, shown as an image behind the overlay.
    Cpu(Box<CpuBackend>, Option<egui::TextureHandle>),
}

/// All that exists while the window is open.
struct Running {
    screen: Screen,
    gpu: Gpu,
    painter: Painter,
    simulation: Option<Simulation>,
    /// Memory that may be taken.
    room: Option<Room>,
    /// How the frame before was drawn.
    drawn: DrawOptions,
    /// Size of that frame.
    drawn_size: [u32; 2],
    /// What its budget counted.
    counted_in: BudgetIn,
    /// What the second camera saw of the frame before, in the corner.
    corner: Option<egui::TextureHandle>,
    samples: u32,
    pose_rates: PoseRates,
    lod_depths_m: Option<[f32; 2]>,
    knobs: Knobs,
    /// Of the knobs, as the painter has it.
    motion: Option<bool>,
    /// With the budget that it gave last.
    governor: Option<(Governor, u32)>,
    readings: Readings,
    control: CameraControl,
    /// The camera path is followed until the user takes over.
    on_path: bool,
    keys: Vec<KeyCode>,
    buttons: Vec<MouseButton>,
    pointer: Option<(f64, f64)>,
    last_frame: Instant,
    frame_count: u32,
    /// Kept only when a report is wanted.
    frames: Option<Vec<Frame>>,
    /// Where the camera was by the window's clock, kept only when that is wanted.
    recording: Option<crowd_scene::CameraPath>,
    records: bool,
    shown_s: f32,
}

impl Running {
    fn new(
        plan: &Plan,
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
        talk.say(&format!("adapter: {} ({:?})", gpu.info.name, gpu.info.backend));
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
                let beside = simulation.as_ref().map(|simulation| ("simulator", simulation.gpu_bytes()));
                let beside = beside.into_iter().collect();
                let kept = Room::new(limit_bytes, crowd, &detail, vec![detail.draw], beside, (format, samples));
                if let Some(asked) = detail.budget.filter(|_| detail.target_ms.is_none()) {
                    kept.fit(&gpu, &mut renderer, screen.size(), Some(asked))?;
                }
                // Sliders and a target rise to what fits.
                largest_budget = kept.fit(&gpu, &mut renderer, screen.size(), None)?;
                let begins_there = detail.budget.is_some() || detail.target_ms.is_some();
                budget = if begins_there { budget.min(largest_budget) } else { largest_budget };
                room = Some(kept);
            }
            renderer.prepare(&gpu.device, &gpu.queue, detail.draw.technique)?;
            Painter::Gpu(Box::new(renderer))
        };
        let readings = Readings {
            adapter: if on_cpu { "CPU (crowd-raster)".to_owned() } else { gpu.info.name.clone() },
            instances: crowd.summary.instances,
            triangles_full: crowd.summary.triangles_full,
            gpu_bytes: if let Painter::Gpu(renderer) = &painter { renderer.gpu_bytes() } else { 0 },
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
            paused: false,
            time_scale: 1.0,
            visible: true,
            reference: plan.reference_camera && !on_cpu,
            screenshot: false,
        };
        let drawn_size = screen.size();
        Ok(Self {
            screen,
            gpu,
            painter,
            simulation,
            drawn: knobs.draw,
            drawn_size,
            counted_in: knobs.budget_in,
            room,
            corner: None,
            samples,
            pose_rates: plan.detail.pose_rates,
            lod_depths_m: plan.detail.lod_depths_m,
            motion: knobs.motion,
            knobs,
            governor: None,
            readings,
            control: CameraControl::new(viewer.at(0.0)),
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
        })
    }

    fn handle(&mut self, event: &WindowEvent, taken: bool, event_loop: &ActiveEventLoop) {
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::Resized(size) => self.screen.resize(&self.gpu.device, [size.width, size.height]),
            WindowEvent::Focused(false) => {
                self.keys.clear();
                self.buttons.clear();
            }
            WindowEvent::KeyboardInput { event, .. } => {
                let PhysicalKey::Code(key) = event.physical_key else { return };
                self.keys.retain(|&held| held != key);
                // Releases count always, so that no key stays down behind a text field.
                if event.state == ElementState::Pressed && !taken {
                    self.keys.push(key);
                    if !event.repeat {
                        self.press(key, event_loop);
                    }
                }
            }
            WindowEvent::MouseInput { state, button, .. } => {
                self.buttons.retain(|held| held != button);
                if *state == ElementState::Pressed && !taken {
                    self.buttons.push(*button);
                }
            }
            WindowEvent::CursorMoved { position, .. } => {
                let before = self.pointer.replace((position.x, position.y));
                if let (Some((x, y)), Some(&button)) = (before, self.buttons.first()) {
                    self.drag(button, (position.x - x) as f32, (position.y - y) as f32);
                }
            }
            WindowEvent::MouseWheel { delta, .. } if !taken => {
                self.on_path = false;
                self.control.wheel(match delta {
                    MouseScrollDelta::LineDelta(_, lines) => *lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 50.0,
                });
            }
            _ => {}
        }
    }

    fn press(&mut self, key: KeyCode, event_loop: &ActiveEventLoop) {
        match key {
            KeyCode::Tab => self.control.switch_mode(),
            KeyCode::Space => self.knobs.paused = !self.knobs.paused,
            KeyCode::KeyF => self.knobs.draw.frozen = !self.knobs.draw.frozen,
            KeyCode::KeyO => self.knobs.draw.occlusion = !self.knobs.draw.occlusion,
            KeyCode::KeyC => self.knobs.reference = !self.knobs.reference,
            KeyCode::KeyR => self.control.reset(),
            KeyCode::KeyP => self.knobs.screenshot = true,
            KeyCode::F1 => self.knobs.visible = !self.knobs.visible,
            KeyCode::Escape => event_loop.exit(),
            _ => {}
        }
    }

    fn drag(&mut self, button: MouseButton, right_px: f32, down_px: f32) {
        self.on_path = false;
        match button {
            MouseButton::Left => self.control.turn(right_px, down_px),
            _ => self.control.shift(right_px, down_px, self.screen.size()[1] as f32),
        }
    }

    fn held(&self) -> Held {
        let axis = |plus: KeyCode, minus: KeyCode| {
            f32::from(u8::from(self.keys.contains(&plus))) - f32::from(u8::from(self.keys.contains(&minus)))
        };
        Held {
            forward: axis(KeyCode::KeyW, KeyCode::KeyS),
            right: axis(KeyCode::KeyD, KeyCode::KeyA),
            up: axis(KeyCode::KeyE, KeyCode::KeyQ),
            fast: self.keys.contains(&KeyCode::ShiftLeft) || self.keys.contains(&KeyCode::ShiftRight),
        }
    }

    fn redraw(&mut self, crowd: &mut Crowd, viewer: &Viewer, talk: &mut Talk<'_>) -> Result<()> {
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
        } else if crowd.advance(self.readings.time_s)
            && let Painter::Gpu(renderer) = &mut self.painter
        {
            renderer.set_instances(&self.gpu.queue, &crowd.instances)?;
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
        if std::mem::take(&mut self.knobs.screenshot) {
            self.save_picture(crowd, &config, talk);
        }
        let budget = self.knobs.budget;
        self.draw(crowd, &config)?;
        self.show_reference(crowd, &camera, &config, &detail)?;
        self.frame_count += 1;
        self.govern(dt_s * 1e3);
        if let Some(frames) = &mut self.frames {
            let Readings { totals, time_s, stages_ms, .. } = &self.readings;
            frames.push(Frame::new(self.frame_count - 1, *time_s, budget, *totals, dt_s * 1e3, stages_ms));
        }
        Ok(())
    }

    /// What people on their places do by now: the GPU looks it up itself, unless it is told that everyone keeps their clip.
    fn play_motion(&mut self, crowd: &mut Crowd) -> Result<()> {
        let poses_here =
            matches!(self.painter, Painter::Cpu(..)) || self.knobs.draw.technique == Technique::StaticFloor;
        if self.knobs.motion == Some(true) && poses_here {
            crowd.play(self.readings.time_s);
        }
        if std::mem::replace(&mut self.motion, self.knobs.motion) == self.knobs.motion {
            return Ok(());
        }
        crowd.instances.iter_mut().for_each(|instance| instance.leaving_share = 0.0);
        if let Painter::Gpu(renderer) = &mut self.painter {
            let plan = crowd.schedules.as_ref().filter(|_| self.knobs.motion == Some(true)).map(Schedules::plan);
            renderer.set_motion(&self.gpu.device, &self.gpu.queue, plan)?;
            renderer.set_instances(&self.gpu.queue, &crowd.instances)?;
        }
        Ok(())
    }

    /// What does not fit the memory that may be taken is not drawn: the frame is as the one before, and the overlay says so.
    fn keep_within_memory(&mut self) {
        if let (Some(room), Painter::Gpu(renderer)) = (&mut self.room, &self.painter)
            && self.knobs.draw != self.drawn
            && !room.admit(&self.gpu, renderer, self.screen.size(), self.knobs.largest_budget, self.knobs.draw)
        {
            self.knobs.draw = self.drawn;
            self.readings.message = Some("that does not fit the memory that may be taken (--vram)".to_owned());
        }
        self.drawn = self.knobs.draw;
        let size = self.screen.size();
        if let (Some(room), Painter::Gpu(renderer)) = (&self.room, &self.painter)
            && std::mem::replace(&mut self.drawn_size, size) != size
            && !room.holds_size(&self.gpu, renderer, size, self.knobs.largest_budget)
        {
            let message = "a window of this size takes more than the memory that may be taken (--vram)";
            self.readings.message = Some(message.to_owned());
        }
    }

    /// Makes other room where the budget counts something else than in the frame before.
    fn recount(&mut self, crowd: &Crowd) {
        if std::mem::replace(&mut self.counted_in, self.knobs.budget_in) == self.knobs.budget_in {
            return;
        }
        if let Painter::Gpu(renderer) = &mut self.painter {
            let (format, budget) = (self.screen.scene_format(), self.knobs.largest_budget);
            let of = renderer_options(&self.gpu.device, crowd, format, self.samples, budget, self.knobs.budget_in);
            renderer.make_room(of.max_vertices, of.max_triangles);
        }
    }

    /// Moves the budget towards the time that a frame may take, if there is one. A budget changed by hand is where it goes on from.
    fn govern(&mut self, frame_ms: f32) {
        let Knobs { budget, largest_budget, target_ms: Some(target_ms), .. } = self.knobs else {
            self.governor = None;
            return;
        };
        let kept = self.governor.take().filter(|(_, last)| *last == budget);
        let mut governor =
            kept.map_or_else(|| Governor::new(target_ms, budget, largest_budget), |(governor, _)| governor);
        governor.aim_at(target_ms);
        let work_ms: f32 = self.readings.stages_ms.iter().map(|(_, ms)| ms).sum();
        self.knobs.budget = governor.next(if work_ms > 0.0 { work_ms } else { frame_ms });
        self.governor = Some((governor, self.knobs.budget));
    }

    fn detail(&self) -> DetailPlan {
        let Knobs {
            budget,
            budget_in,
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
            budget_in,
            slack_share: steady_percent / 100.0,
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

    fn draw(&mut self, crowd: &Crowd, config: &FrameConfig) -> Result<()> {
        let Self { screen, gpu, painter, simulation, corner, knobs, readings, control, .. } = self;
        if let Painter::Cpu(cpu, image) = painter {
            cpu.resize(screen.size());
            readings.totals = cpu.draw(crowd, config, knobs.draw);
            readings.stages_ms = cpu.timings_ms();
            show_image(&screen.egui, image, &cpu.picture());
        }
        let behind = if let Painter::Cpu(_, Some(image)) = painter { Some(image.id()) } else { None };
        let output = screen.run_overlay(|ui| {
            if let Some(image) = behind {
                let whole = egui::Rect::from_min_max(egui::pos2(0.0, 0.0), egui::pos2(1.0, 1.0));
                let area = ui.ctx().content_rect();
                ui.ctx().layer_painter(egui::LayerId::background()).image(image, area, whole, egui::Color32::WHITE);
            }
            if let Some(image) = corner {
                paint_corner(ui, image);
            }
            overlay::show(ui, knobs, readings, control);
        });
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
        if let Painter::Gpu(renderer) = painter
            && drawn
        {
            readings.totals = renderer.totals(&gpu.device, false).unwrap_or(readings.totals);
            readings.stages_ms = renderer.timings_ms();
            readings.gpu_bytes = renderer.gpu_bytes();
            readings.skinning = Some(renderer.skinning(knobs.draw.skinning));
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
        let Self { screen, gpu, painter, knobs, corner, .. } = self;
        let Painter::Gpu(renderer) = painter else { return Ok(()) };
        if !knobs.reference || !knobs.can_show_reference() {
            *corner = None;
            return Ok(());
        }
        let size = screen.size();
        let other = view::reference_camera(crowd, camera, size[0] as f32 / size[1].max(1) as f32);
        let other = frame_config(&other, size, config.time_s, detail, config.budget);
        match draw_reference(gpu, renderer, size, screen.scene_format(), [config, &other], knobs.draw) {
            Ok(picture) => show_image(&screen.egui, corner, &picture.reduced()),
            // A window that is hidden draws no frame that could be seen from elsewhere.
            Err(Error::Stages(crowd_stages::Error::NoFrame { .. })) => *corner = None,
            Err(error) => return Err(error),
        }
        Ok(())
    }

    /// The scene without the overlay, under the first free name in the current folder. A failure is shown, not fatal.
    fn save_picture(&mut self, crowd: &Crowd, config: &FrameConfig, talk: &mut Talk<'_>) {
        let file = free_name();
        let written = self.take_picture(crowd, config).and_then(|picture| write_file(&file, &picture.to_png()));
        let message = match written {
            Ok(()) => format!("wrote {}", file.display()),
            Err(error) => error.to_string(),
        };
        talk.say(&message);
        self.readings.message = Some(message);
    }

    fn take_picture(&mut self, crowd: &Crowd, config: &FrameConfig) -> Result<Picture> {
        let Self { screen, gpu, painter, simulation, knobs, .. } = self;
        match painter {
            Painter::Cpu(cpu, _) => {
                cpu.resize(screen.size());
                let _: FrameTotals = cpu.draw(crowd, config, knobs.draw);
                Ok(cpu.picture())
            }
            Painter::Gpu(renderer) => {
                bake_frame(gpu, renderer, simulation.as_ref(), crowd, config, knobs.draw)?;
                let canvas = Canvas::new(&gpu.device, screen.size(), screen.scene_format())?;
                let mut encoder = gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
                let size = (canvas.size[0], canvas.size[1]);
                renderer.encode(&gpu.device, &gpu.queue, &mut encoder, &canvas.view, size, config, knobs.draw)?;
                gpu.queue.submit([encoder.finish()]);
                canvas.read(&gpu.device, &gpu.queue)
            }
        }
    }

    fn into_report(self, plan: &Plan, crowd: &Crowd) -> Report {
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
        if let Painter::Gpu(renderer) = &self.painter {
            report.set_memory(&renderer.memory().parts());
        }
        report.frames = self.frames.unwrap_or_default();
        report.timings = Timings::of(&report.frames);
        report
    }
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

fn show_image(egui: &egui::Context, image: &mut Option<egui::TextureHandle>, picture: &Picture) {
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
