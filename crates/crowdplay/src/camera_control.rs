//! Orbit and fly: what drags, wheel and keys do to the camera. No window in here; angles and metres only.

use crowd_scene::Camera;
use glam::Vec3;

/// How drags and the wheel are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Around a point in front of the camera.
    Orbit,
    /// The camera turns on the spot.
    Fly,
}

/// Directions held down, each -1, 0 or 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Held {
    /// W and S.
    pub forward: f32,
    /// D and A.
    pub right: f32,
    /// E and Q.
    pub up: f32,
    /// Shift.
    pub fast: bool,
}

/// A camera one can steer. Both modes share one state, so that switching does not move the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CameraControl {
    /// How drags and the wheel are read.
    pub mode: Mode,
    home: Camera,
    eye: Vec3,
    /// 0 looks along +Z, positive turns towards +X.
    yaw_rad: f32,
    /// Positive looks up.
    pitch_rad: f32,
    /// From the eye to the orbit's middle.
    distance_m: f32,
    speed_m_s: f32,
}

/// Radians a pixel of drag.
const TURN_RAD: f32 = 0.005;
/// Just short of straight up or down.
const STEEPEST_RAD: f32 = 1.55;
/// The eye stays above the ground.
const LOWEST_M: f32 = 0.05;

impl CameraControl {
    /// Starts at a camera.
    pub fn new(home: Camera) -> Self {
        let way = home.target - home.eye;
        let distance_m = way.length().max(0.01);
        let ahead = way / distance_m;
        Self {
            mode: Mode::Orbit,
            home,
            eye: home.eye,
            yaw_rad: libm::atan2f(ahead.x, ahead.z),
            pitch_rad: libm::asinf(ahead.y.clamp(-1.0, 1.0)).clamp(-STEEPEST_RAD, STEEPEST_RAD),
            distance_m,
            speed_m_s: (0.5 * distance_m).clamp(2.0, 20.0),
        }
    }

    /// Back to the start.
    pub fn reset(&mut self) {
        self.stand_at(self.home);
    }

    /// Takes a camera over, which becomes the start.
    pub fn stand_at(&mut self, camera: Camera) {
        *self = Self { mode: self.mode, ..Self::new(camera) };
    }

    /// Orbit to fly and back.
    pub fn switch_mode(&mut self) {
        self.mode = if self.mode == Mode::Orbit { Mode::Fly } else { Mode::Orbit };
    }

    /// A drag with the first button, pixels.
    pub fn turn(&mut self, right_px: f32, down_px: f32) {
        let middle = self.middle();
        // The scene follows the hand in orbit, the gaze does in flight.
        let sign = if self.mode == Mode::Orbit { -1.0 } else { 1.0 };
        self.yaw_rad -= right_px * TURN_RAD;
        self.pitch_rad = (self.pitch_rad + sign * down_px * TURN_RAD).clamp(-STEEPEST_RAD, STEEPEST_RAD);
        if self.mode == Mode::Fly {
            return;
        }
        self.eye = middle - self.distance_m * self.ahead();
        self.stay_above_ground();
    }

    /// A drag with another button, pixels: the scene follows the hand. `height_px` of the picture.
    pub fn shift(&mut self, right_px: f32, down_px: f32, height_px: f32) {
        let metres_a_pixel = 2.0 * self.distance_m * libm::tanf(0.5 * self.home.fov_y_rad) / height_px.max(1.0);
        let (right, up) = self.right_and_up();
        self.eye += metres_a_pixel * (up * down_px - right * right_px);
        self.stay_above_ground();
    }

    /// Clicks of the wheel, positive away from the user: closer in orbit, faster in flight.
    pub fn wheel(&mut self, clicks: f32) {
        let factor = libm::expf(0.15 * clicks.clamp(-20.0, 20.0));
        match self.mode {
            Mode::Orbit => {
                let middle = self.middle();
                self.distance_m = (self.distance_m / factor).clamp(0.2, 10_000.0);
                self.eye = middle - self.distance_m * self.ahead();
                self.stay_above_ground();
            }
            Mode::Fly => self.speed_m_s = (self.speed_m_s * factor).clamp(0.1, 1_000.0),
        }
    }

    /// Moves on with the keys held for `dt_s`; in orbit the middle comes along.
    pub fn advance(&mut self, held: Held, dt_s: f32) {
        let (right, _) = self.right_and_up();
        let way = held.forward * self.ahead() + held.right * right + held.up * Vec3::Y;
        let speed = if held.fast { 5.0 * self.speed_m_s } else { self.speed_m_s };
        self.eye += way.normalize_or_zero() * speed * dt_s;
        self.stay_above_ground();
    }

    /// The camera as it stands.
    pub fn camera(&self) -> Camera {
        let near_m = self.home.near_m.min(0.02 * self.distance_m).max(0.01);
        Camera { eye: self.eye, target: self.eye + self.distance_m * self.ahead(), near_m, ..self.home }
    }

    /// Metres a second with the keys.
    pub fn speed_m_s(&self) -> f32 {
        self.speed_m_s
    }

    fn ahead(&self) -> Vec3 {
        let (sin_yaw, cos_yaw) = libm::sincosf(self.yaw_rad);
        let (sin_pitch, cos_pitch) = libm::sincosf(self.pitch_rad);
        Vec3::new(sin_yaw * cos_pitch, sin_pitch, cos_yaw * cos_pitch)
    }

    fn right_and_up(&self) -> (Vec3, Vec3) {
        let right = self.ahead().cross(Vec3::Y).normalize_or_zero();
        (right, right.cross(self.ahead()))
    }

    fn middle(&self) -> Vec3 {
        self.eye + self.distance_m * self.ahead()
    }

    fn stay_above_ground(&mut self) {
        self.eye.y = self.eye.y.max(LOWEST_M);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn control() -> CameraControl {
        let eye = Vec3::new(1.0, 3.0, 12.0);
        CameraControl::new(Camera { eye, ..Camera::orbit(Vec3::new(0.0, 1.0, 2.0), 10.0, 0.0, 0.0) })
    }

    fn near(a: Vec3, b: Vec3) -> bool {
        (a - b).length() < 1e-3
    }

    #[test]
    fn starts_where_it_was_told_and_comes_back() {
        let mut it = control();
        let start = it.camera();
        assert!(near(start.eye, Vec3::new(1.0, 3.0, 12.0)) && near(start.target, Vec3::new(0.0, 1.0, 2.0)));
        it.turn(100.0, 50.0);
        it.wheel(3.0);
        it.advance(Held { forward: 1.0, ..Held::default() }, 2.0);
        assert!(!near(it.camera().eye, start.eye));
        it.reset();
        assert_eq!(it.camera(), start);
    }

    #[test]
    fn orbit_keeps_its_middle_and_distance() {
        let mut it = control();
        let before = it.camera();
        it.turn(80.0, 30.0);
        let after = it.camera();
        assert!(near(before.target, after.target));
        assert!((before.eye.distance(before.target) - after.eye.distance(after.target)).abs() < 1e-3);
        assert!(after.eye.y > before.eye.y, "dragging down looks from higher up");
        it.wheel(4.0);
        assert!(it.camera().eye.distance(before.target) < 0.7 * after.eye.distance(before.target));
    }

    #[test]
    fn flight_keeps_its_eye_and_switching_keeps_the_picture() {
        let mut it = control();
        let before = it.camera();
        it.switch_mode();
        assert_eq!(it.camera(), before);
        it.turn(80.0, 30.0);
        assert!(near(it.camera().eye, before.eye) && !near(it.camera().target, before.target));
    }

    #[test]
    fn keys_move_along_the_gaze_and_never_under_the_ground() {
        let mut it = control();
        let before = it.camera();
        it.advance(Held { right: 1.0, ..Held::default() }, 1.0);
        assert!(it.camera().eye.x > before.eye.x, "looking along -Z, right is +X");
        it.advance(Held { up: -1.0, ..Held::default() }, 1e3);
        assert_eq!(it.camera().eye.y, LOWEST_M);
    }

    #[test]
    fn dragging_to_the_right_turns_the_scene_with_the_hand() {
        let mut it = control();
        it.turn(20.0, 0.0);
        assert!(it.camera().eye.x < 1.0, "the eye goes left, so the scene goes right");
    }
}
