//! Camera paths that are made, not recorded: around a point, straight on, and a walk through the crowd.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use crate::Camera;
use crate::camera_path::{CameraKey, CameraPath};

/// Keys of a full turn: straight between them, a camera 20 m away is 3 mm off its circle.
const KEYS_A_TURN: f32 = 180.0;
/// Frames of the walkthrough that Dong & Peng 2019 (§6.1) measure along.
const WALKTHROUGH_KEYS: u32 = 1000;

impl CameraPath {
    /// Around `target` at a constant pace, from one azimuth to another (0 stands on +Z, positive goes to +X).
    ///
    /// `elevation_rad`: above the horizontal. Within `seconds`, which is made at least 1/100.
    pub fn orbit(
        target: Vec3,
        distance_m: f32,
        elevation_rad: f32,
        [from_rad, to_rad]: [f32; 2],
        seconds: f32,
        fov_y_rad: f32,
    ) -> Self {
        let turns = ((to_rad - from_rad) / TAU).abs().min(50.0);
        let steps = (turns * KEYS_A_TURN).ceil().max(1.0) as u32;
        let key = |step: u32| {
            let t = step as f32 / steps as f32;
            let camera = Camera::orbit(target, distance_m, from_rad + (to_rad - from_rad) * t, elevation_rad);
            CameraKey { time_s: seconds.max(0.01) * t, eye: camera.eye, target, fov_y_rad }
        };
        Self::from_keys((0..=steps).map(key))
    }

    /// Straight over the box from one corner to the other at a constant pace, `eye_m` above its floor and looking ahead:
    /// the second film of Dong & Peng 2019.
    pub fn straight(low: Vec3, high: Vec3, eye_m: f32, seconds: f32, fov_y_rad: f32) -> Self {
        let start = Vec3::new(low.x, low.y + eye_m, high.z);
        let end = Vec3::new(high.x, low.y + eye_m, low.z);
        let end = if end.distance(start) < 1.0 { start + Vec3::NEG_Z } else { end };
        // Looks at the ground as far ahead as the box is long.
        let ahead = (end - start) - Vec3::Y * eye_m * 0.9;
        let key = |t: f32| {
            let eye = start.lerp(end, t);
            CameraKey { time_s: seconds.max(0.01) * t, eye, target: eye + ahead, fov_y_rad }
        };
        Self::from_keys([key(0.0), key(1.0)])
    }

    /// A walk through a crowd in a box, 1,000 keys: down from a view of everyone, in at the front, winding through at eye
    /// height, round at the far end, and up again. Dong & Peng 2019 (§6.1) describe theirs as a game's navigation of 1,000
    /// frames that sees between 17 % and all of the crowd; its points are not published, so these are ours.
    pub fn walkthrough(low: Vec3, high: Vec3, eye_m: f32, seconds: f32, fov_y_rad: f32) -> Self {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low).max(Vec3::splat(4.0)));
        let floor = low.y;
        let wide = Vec2::new(half.x, half.z).length();
        // Of the box: -1 to 1 across, -1 (far) to 1 (near); metres above the floor.
        let at = |x: f32, z: f32, up: f32| Vec3::new(middle.x + x * half.x, floor + up, middle.z + z * half.z);
        let eye = eye_m.max(0.1);
        let high_up = 0.9 * wide + eye;
        let ways = [
            (at(0.0, 1.0, high_up) + Vec3::Z * 1.9 * wide, at(0.0, 0.0, 0.0)),
            (at(0.3, 1.0, 0.45 * high_up) + Vec3::Z * wide, at(0.0, 0.2, 0.0)),
            (at(0.25, 1.0, eye * 1.4) + Vec3::Z * 0.25 * wide, at(0.1, 0.0, eye)),
            (at(0.15, 0.7, eye), at(-0.3, 0.0, eye)),
            (at(-0.35, 0.25, eye), at(-0.1, -0.6, eye)),
            (at(-0.2, -0.25, eye), at(0.5, -0.6, eye)),
            (at(0.35, -0.5, eye), at(0.6, -1.0, eye)),
            (at(0.5, -0.8, eye), at(-0.6, -0.9, eye)),
            (at(0.1, -0.9, eye), at(-0.6, -0.2, eye)),
            (at(-0.4, -0.75, eye * 1.6), at(-0.1, 0.4, eye)),
            (at(-0.6, -1.0, 0.3 * high_up) - Vec3::Z * 0.3 * wide, at(0.0, 0.1, 0.0)),
            (at(-0.8, -1.0, high_up) - Vec3::Z * 1.5 * wide, at(0.0, 0.0, 0.0)),
        ];
        let key = |number: u32| {
            let t = number as f32 / (WALKTHROUGH_KEYS - 1) as f32;
            let along = t * (ways.len() - 1) as f32;
            let mut place = spline(&ways.map(|way| way.0), along);
            // The curve swings below its lowest points.
            place.y = place.y.max(floor + eye);
            let eye = place;
            let target = spline(&ways.map(|way| way.1), along);
            let target = if target.distance(eye) < 0.01 { eye + Vec3::NEG_Z } else { target };
            CameraKey { time_s: seconds.max(0.01) * t, eye, target, fov_y_rad }
        };
        Self::from_keys((0..WALKTHROUGH_KEYS).map(key))
    }
}

/// Catmull-Rom through all points; `along` from 0 to one less than their count.
fn spline(points: &[Vec3], along: f32) -> Vec3 {
    let last = points.len() - 1;
    let leg = (along as usize).min(last.saturating_sub(1));
    let t = along - leg as f32;
    let at = |i: usize| points[i.min(last)];
    let (a, b, c, d) = (at(leg.saturating_sub(1)), at(leg), at(leg + 1), at(leg + 2));
    let linear = (c - a) * t;
    let square = (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t);
    let cube = (b * 3.0 - a - c * 3.0 + d) * (t * t * t);
    b + 0.5 * (linear + square + cube)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planes() -> Camera {
        Camera::orbit(Vec3::ZERO, 10.0, 0.0, 0.0)
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_pace() {
        let path = CameraPath::orbit(Vec3::new(1.0, 2.0, 3.0), 20.0, 0.4, [0.0, TAU], 12.0, 0.8);
        assert_eq!(path.end_s(), 12.0);
        for i in 0..240 {
            let camera = path.at(i as f32 * 0.05, &planes());
            assert!((camera.eye.distance(camera.target) - 20.0).abs() < 0.005);
        }
        let quarter = path.at(3.0, &planes());
        assert!(quarter.eye.x > 18.0 && (quarter.eye.z - 3.0).abs() < 0.1, "{}", quarter.eye);
    }

    #[test]
    fn a_straight_line_goes_from_corner_to_corner() {
        let path = CameraPath::straight(Vec3::new(-10.0, 0.0, -5.0), Vec3::new(10.0, 2.0, 5.0), 3.0, 10.0, 0.8);
        assert_eq!(path.at(0.0, &planes()).eye, Vec3::new(-10.0, 3.0, 5.0));
        assert!(path.at(5.0, &planes()).eye.distance(Vec3::new(0.0, 3.0, 0.0)) < 1e-4);
        let camera = path.at(2.0, &planes());
        assert!(camera.target.y < camera.eye.y && camera.target.z < camera.eye.z);
    }

    #[test]
    fn the_walkthrough_has_a_thousand_keys_sees_everyone_and_goes_among_them() {
        let (low, high) = (Vec3::new(-50.0, 0.0, -50.0), Vec3::new(50.0, 1.8, 50.0));
        let path = CameraPath::walkthrough(low, high, 1.7, 33.3, 0.8);
        assert_eq!(path.keys().len(), 1000);
        let first = path.at(0.0, &Camera { far_m: 1000.0, ..planes() }).clip_from_world(16.0 / 9.0);
        for corner in [low, high, Vec3::new(low.x, 0.0, high.z), Vec3::new(high.x, 0.0, low.z)] {
            let seen = first.project_point3(corner);
            assert!(seen.x.abs() < 1.0 && seen.y.abs() < 1.0, "{corner} at {seen}");
        }
        let among = path.keys().iter().filter(|key| key.eye.y < 3.0 && key.eye.abs().max_element() < 50.0).count();
        assert!(among > 400, "{among}");
        assert!(path.keys().iter().all(|key| key.eye.y > 1.0));
        // Nobody is thrown about: at most a few metres from key to key.
        let fastest = path.keys().windows(2).map(|pair| pair[0].eye.distance(pair[1].eye)).fold(0.0, f32::max);
        assert!(fastest < 2.0, "{fastest}");
    }
}
