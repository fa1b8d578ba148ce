//! Keys, mouse and the window's own events.

use super::running::Running;
use crate::camera_control::Held;
use crate::overlay::Shot;
use crowd_stages::{DrawOptions, View};
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::ActiveEventLoop;
use winit::keyboard::{KeyCode, PhysicalKey};

impl Running {
    /// What the user does, other than to the overlay.
    pub(super) fn handle(&mut self, event: &WindowEvent, taken: bool, event_loop: &ActiveEventLoop) {
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
            KeyCode::KeyV => self.knobs.draw.view = next_view(self.knobs.draw),
            KeyCode::KeyP => self.knobs.shot = Some(Shot::Crowd),
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

    /// Directions of the keys that are down.
    pub(super) fn held(&self) -> Held {
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
}

/// The next view in turn that has something to show.
fn next_view(draw: DrawOptions) -> View {
    let at = View::ALL.iter().position(|view| *view == draw.shown_view()).unwrap_or(0);
    let mut others = View::ALL.into_iter().cycle().skip(at + 1).take(View::ALL.len());
    others.find(|view| DrawOptions { view: *view, ..draw }.shown_view() == *view).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_stages::Technique;

    #[test]
    fn views_come_in_turn_and_those_without_meaning_are_left_out() {
        let mut draw = DrawOptions::from(Technique::Bucketed);
        let mut seen = Vec::new();
        for _ in 0..4 {
            draw.view = next_view(draw);
            seen.push(draw.view);
        }
        assert_eq!(seen, [View::Levels, View::Density, View::Representation, View::Shaded]);
        assert_eq!(next_view(DrawOptions { occlusion: true, ..draw }), View::Occlusion);
        assert_eq!(next_view(Technique::Discrete.into()), View::Shaded);
    }
}
