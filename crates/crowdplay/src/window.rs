//! The window: an event loop around the renderer, a camera one can steer, and the overlay.

mod running;
mod shots;
mod steering;
mod upkeep;

use crate::crowd::Crowd;
use crate::headless::write_recording;
use crate::loss;
use crate::plan::{Plan, WindowPlan};
use crate::stats::Report;
use crate::view::Viewer;
use crate::{Error, Result, Talk};
use running::Running;
use std::path::Path;
use std::sync::Arc;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoop};
use winit::window::{Window, WindowId};

const REMEDY: &str = "use --headless --out picture.png to draw without a window";

/// Opens the window and runs until it is closed, or for as many frames as the plan says.
///
/// # Errors
/// [`Error::Machine`] without a display, or without a GPU that can draw to it; [`Error::Output`] when a picture of the
/// window is wanted and the window was taken away before it could be made.
pub fn show(plan: &Plan, shown: &WindowPlan, crowd: Crowd, viewer: Viewer, talk: &mut Talk<'_>) -> Result<Report> {
    let no_window = |e: winit::error::EventLoopError| {
        let words = e.to_string();
        // Before its own words it says in which line of its source they stand.
        let what = format!("no window: {}", words.rsplit(": ").next().unwrap_or_default());
        Error::Machine { what, remedy: REMEDY }
    };
    let event_loop = EventLoop::new().map_err(no_window)?;
    event_loop.set_control_flow(ControlFlow::Poll);
    let screenshot = shown.screenshot.as_deref();
    let mut app = App { plan, shown, crowd, viewer, talk, running: None, screenshot, failure: None };
    let ran = event_loop.run_app(&mut app).map_err(no_window);
    if let Some(running) = app.running.take_if(|_| loss::latest().is_some()) {
        running.gpu.let_finish();
        // wgpu panics where the surface of a lost device is put away.
        std::mem::forget(running);
    }
    ran?;
    if let Some(error) = app.failure {
        return Err(error);
    }
    let running = app.running.ok_or_else(|| Error::Machine {
        what: "the window was closed before the first frame".to_owned(),
        remedy: REMEDY,
    })?;
    write_recording(plan, running.recording.as_ref())?;
    if let Some(file) = app.screenshot {
        let what = format!("the window was taken away after frame {}, before its picture", running.frame_count);
        return Err(Error::Output { path: file.to_owned(), source: std::io::Error::other(what) });
    }
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
    shown: &'a WindowPlan,
    crowd: Crowd,
    viewer: Viewer,
    talk: &'a mut Talk<'talk>,
    running: Option<Running>,
    /// Where the picture of the window goes, until it is written.
    screenshot: Option<&'a Path>,
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
        Running::new(self.plan, self.shown, &self.crowd, &self.viewer, Arc::new(window), event_loop, self.talk)
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
        if event == WindowEvent::RedrawRequested && !event_loop.exiting() {
            let drawn = running.redraw(&mut self.crowd, &self.viewer, self.talk);
            let is_last = self.shown.frames.is_some_and(|frames| running.frame_count >= frames);
            let kept = drawn.and_then(|()| match self.screenshot.take_if(|_| is_last) {
                Some(file) => running.save_window(&self.crowd, file, self.talk),
                None => Ok(()),
            });
            if let Err(error) = kept {
                self.failure = Some(error);
                event_loop.exit();
            }
            if is_last {
                event_loop.exit();
            }
            running.screen.window.request_redraw();
        }
        // Of a window that is gone nothing can be asked any more, as whoever kills it from outside takes it away at once.
        if event == WindowEvent::Destroyed {
            event_loop.exit();
        }
        if event_loop.exiting() || event == WindowEvent::RedrawRequested {
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
        // Closed by a person before its last frame: the picture is of the last that there was.
        if event_loop.exiting()
            && running.frame_count > 0
            && let Some(file) = self.screenshot.take()
        {
            self.talk.say(&format!("closed after frame {} of --frames", running.frame_count));
            self.failure = running.save_window(&self.crowd, file, self.talk).err();
        }
    }
}
