//! Cameras: matrices, orbits, and one that makes a picture of a crowd.

use glam::camera::rh::{proj::directx::perspective, view::look_at_mat4};
use glam::{Mat4, Vec3};

use crate::{Camera, Instance, Kind};

/// Vertical field of view of the cameras made here: 45 degrees.
const FOV_Y_RAD: f32 = std::f32::consts::FRAC_PI_4;
/// Where the horizon lies in a crowd picture, in half picture heights above the middle.
const HORIZON: f32 = 0.42;
/// Crowds up to this many are shown whole.
const SHOWN_WHOLE: usize = 16;
/// Crowds up to this many are shown from head to foot, but run out of the picture sideways, the more the larger they
/// are; of still larger ones the near people fill the picture's width.
const SHOWN_FROM_HEAD_TO_FOOT: usize = 64;

impl Camera {
    /// World to clip space, depth 0 to 1, Y up (wgpu's convention). `aspect`: width over height.
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        perspective(self.fov_y_rad, aspect, self.near_m, self.far_m) * self.view_from_world()
    }

    /// World to view space: looking along -Z, Y up. Straight up or down, the picture's top points to -Z.
    pub fn view_from_world(&self) -> Mat4 {
        let forward = self.target - self.eye;
        let across = forward.x * forward.x + forward.z * forward.z;
        if forward == Vec3::ZERO {
            return look_at_mat4(self.eye, self.eye + Vec3::NEG_Z, Vec3::Y);
        }
        let up = if across > 1e-8 * forward.length_squared() { Vec3::Y } else { Vec3::NEG_Z };
        look_at_mat4(self.eye, self.target, up)
    }

    /// Looks at `center` from `distance` metres. `azimuth_rad`: 0 stands on +Z (where the faces are seen), positive goes to
    /// +X; `elevation_rad`: above the horizontal. Planes fit the distance.
    pub fn orbit(center: Vec3, distance: f32, azimuth_rad: f32, elevation_rad: f32) -> Self {
        let (sin_a, cos_a) = libm::sincosf(azimuth_rad);
        let (sin_e, cos_e) = libm::sincosf(elevation_rad);
        let away = Vec3::new(sin_a * cos_e, sin_e, cos_a * cos_e);
        let near_m = (distance * 0.01).clamp(0.01, 0.5);
        Self {
            eye: center + away * distance,
            target: center,
            fov_y_rad: FOV_Y_RAD,
            near_m,
            far_m: (distance * 20.0).max(500.0),
        }
    }

    /// The camera after `turns` full turns around the vertical through its target (1 is where it began).
    pub fn orbited(&self, turns: f32) -> Self {
        let (sin, cos) = libm::sincosf((turns - turns.floor()) * std::f32::consts::TAU);
        let arm = self.eye - self.target;
        let turned = Vec3::new(arm.x * cos + arm.z * sin, arm.y, arm.z * cos - arm.x * sin);
        Self { eye: self.target + turned, ..*self }
    }

    /// The camera on the straight line to `other`, `t` from 0 (here) to 1 (there), held beyond both ends.
    pub fn towards(&self, other: &Self, t: f32) -> Self {
        let t = if t > 0.0 { t.min(1.0) } else { 0.0 };
        let mix = |a: f32, b: f32| a * (1.0 - t) + b * t;
        Self {
            eye: self.eye * (1.0 - t) + other.eye * t,
            target: self.target * (1.0 - t) + other.target * t,
            fov_y_rad: mix(self.fov_y_rad, other.fov_y_rad),
            near_m: mix(self.near_m, other.near_m),
            far_m: mix(self.far_m, other.far_m),
        }
    }
}

/// A camera that makes a picture of the crowd: from the front (+Z), a little above the heads, near people large, the
/// horizon in the upper third. `aspect`: width over height. The height of the people is guessed from their footprints;
/// [`frame_crowd`] takes it where it is known.
pub fn framing_crowd(instances: &[Instance], kinds: &[Kind], aspect: f32) -> Camera {
    let widest = kinds.iter().map(|kind| kind.footprint_m).filter(|f| f.is_finite()).fold(0.0, f32::max);
    frame_crowd(instances, (widest * 4.0).clamp(1.0, 2.2), aspect)
}

/// As [`framing_crowd`], for people of `height_m` metres. An empty crowd is taken as one person in the origin.
pub fn frame_crowd(instances: &[Instance], height_m: f32, aspect: f32) -> Camera {
    let height = if height_m.is_finite() { height_m.clamp(0.05, 100.0) } else { 1.8 };
    let aspect = if aspect.is_finite() { aspect.clamp(0.1, 10.0) } else { 1.0 };
    let (low, high) = extent_of(instances);
    let middle_x = (low.x + high.x) * 0.5;
    let place = Place { low, high, height, side: side_of_the_faces(instances, middle_x) };
    if instances.len() <= SHOWN_FROM_HEAD_TO_FOOT {
        return frame_whole(&place, instances, aspect);
    }
    // The higher the eye, the more of the back rows is seen, and the smaller the near people: a third of a body above the
    // heads, rising with the extent up to two bodies more.
    let eye_height = height * 1.3 + (0.035 * (high.z - low.z)).min(height * 2.0);
    place.seen_from(eye_height / tan_of_lowest_ray(), eye_height)
}

/// A camera that has the whole box between two corners in the picture, seen from the front (+Z), the right and above: 35
/// degrees above the ground, 25 to the side. `aspect`: width over height.
pub fn overlook(low: Vec3, high: Vec3, aspect: f32) -> Camera {
    let (low, high) = if low.is_finite() && high.is_finite() { (low, high) } else { (Vec3::ZERO, Vec3::ONE) };
    let aspect = if aspect.is_finite() { aspect.clamp(0.1, 10.0) } else { 1.0 };
    let middle = 0.5 * (low + high);
    let seen_at = |distance: f32| Camera::orbit(middle, distance, 25.0_f32.to_radians(), 35.0_f32.to_radians());
    let corners = (0..8).map(|i| {
        let pick = |bit: u32, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
        Vec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    });
    let corners: Vec<Vec3> = corners.collect();
    let is_cut = |distance: f32| {
        let clip_from_world = seen_at(distance).clip_from_world(aspect);
        corners.iter().any(|corner| {
            let p = clip_from_world * corner.extend(1.0);
            p.w <= 0.0 || p.x.abs().max(p.y.abs()) > 0.94 * p.w
        })
    };
    let farthest = 20.0 * (high - low).length().max(1.0);
    seen_at(last_where((1.0, farthest), is_cut) * 1.001)
}

/// The nearest camera that has everyone in the picture from head to foot, as high as leaves half as much room below
/// the crowd as above it. Of more than [`SHOWN_WHOLE`] some stand beside the picture.
fn frame_whole(place: &Place, instances: &[Instance], aspect: f32) -> Camera {
    let nobody = [Vec3::ZERO];
    let mut feet: Vec<Vec3> = instances.iter().map(|instance| instance.position).filter(|p| p.is_finite()).collect();
    if feet.is_empty() {
        feet.extend(nobody);
    }
    // Nearer than this, the horizon through one person's forehead, head and feet leave the picture.
    let lowest_eye = place.height * 0.88;
    let nearest = lowest_eye / tan_of_lowest_ray();
    let at = |distance: f32| {
        let heights = (lowest_eye, (distance * tan_of_lowest_ray()).max(lowest_eye));
        let is_low = |eye: f32| {
            let box_ = box_of(&place.seen_from(distance, eye), aspect, &feet, place.height);
            2.0 * (box_.low + 1.0) > 1.0 - box_.high
        };
        place.seen_from(distance, last_where(heights, is_low))
    };
    let more = instances.len().saturating_sub(SHOWN_WHOLE) as f32;
    let across = 0.95 + 0.6 * more / (SHOWN_FROM_HEAD_TO_FOOT - SHOWN_WHOLE) as f32;
    let is_cut = |distance: f32| {
        let box_ = box_of(&at(distance), aspect, &feet, place.height);
        !(box_.across < across && box_.low > -0.97 && box_.high < 0.95)
    };
    let mut farthest = nearest;
    for _ in 0..40 {
        if !is_cut(farthest) {
            break;
        }
        farthest *= 2.0;
    }
    // The search ends a little on the side of those cut off.
    at(last_where((nearest, farthest), is_cut) * 1.001)
}

/// The end of the range's first part, where `is_so`; its start when that is nowhere.
fn last_where((mut low, mut high): (f32, f32), is_so: impl Fn(f32) -> bool) -> f32 {
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if is_so(middle) { low = middle } else { high = middle }
    }
    low
}

/// What of the picture people take, in normalised device coordinates.
struct Box2 {
    low: f32,
    high: f32,
    /// Greatest distance from the middle, sideways.
    across: f32,
}

fn box_of(camera: &Camera, aspect: f32, feet: &[Vec3], height: f32) -> Box2 {
    let clip_from_world = camera.clip_from_world(aspect);
    let mut box_ = Box2 { low: f32::INFINITY, high: f32::NEG_INFINITY, across: 0.0 };
    // Arms and stride: a third of the height to each side.
    let corners = [Vec3::new(-0.33, 0.0, 0.0), Vec3::new(0.33, 0.0, 0.0), Vec3::new(0.0, 1.0, 0.0)];
    for corner in feet.iter().flat_map(|foot| corners.map(|corner| *foot + corner * height)) {
        let seen = clip_from_world.project_point3(corner);
        box_.low = box_.low.min(seen.y);
        box_.high = box_.high.max(seen.y);
        box_.across = box_.across.max(seen.x.abs());
    }
    box_
}

/// Slope of a ray a little above the picture's lower edge, downwards.
fn tan_of_lowest_ray() -> f32 {
    let tan_half = libm::tanf(FOV_Y_RAD * 0.5);
    libm::tanf(libm::atanf(HORIZON * tan_half) + libm::atanf(tan_half) * 0.94)
}

/// The crowd as the framing sees it.
struct Place {
    low: Vec3,
    high: Vec3,
    height: f32,
    /// See [`side_of_the_faces`].
    side: f32,
}

impl Place {
    /// From `distance` metres before the front row and `eye_height` above the ground, both metres.
    fn seen_from(&self, distance: f32, eye_height: f32) -> Camera {
        let Self { low, high, height, side } = *self;
        let (width, depth) = (high.x - low.x, high.z - low.z);
        let middle_x = (low.x + high.x) * 0.5;
        let reach = distance + depth * 0.5 + 1.0;
        // Eyes a little to the side see bodies, not only a wall of faces.
        let beside = 0.18 * (distance + 0.15 * depth) * side;
        let eye = Vec3::new(middle_x + beside, low.y + eye_height, high.z + distance);
        let pitch_tan = HORIZON * libm::tanf(FOV_Y_RAD * 0.5);
        Camera {
            eye,
            target: Vec3::new(middle_x, eye.y - pitch_tan * reach, eye.z - reach),
            fov_y_rad: FOV_Y_RAD,
            near_m: (height * 0.06).min(0.1),
            far_m: (3.0 * (depth + width)).max(3.0 * distance + depth).max(600.0),
        }
    }
}

/// -1 where those who look at the camera (+Z) stand on the left (-X), as in a street of two streams; else 1.
fn side_of_the_faces(instances: &[Instance], middle_x: f32) -> f32 {
    let (mut balance, mut spread) = (0.0_f64, 0.0_f64);
    for instance in instances.iter().filter(|instance| instance.position.is_finite() && instance.yaw_rad.is_finite()) {
        let away = f64::from(instance.position.x - middle_x);
        balance += away * f64::from(libm::cosf(instance.yaw_rad));
        spread += away.abs();
    }
    if balance < -0.3 * spread { -1.0 } else { 1.0 }
}

/// Smallest and largest position; those not finite are passed over.
fn extent_of(instances: &[Instance]) -> (Vec3, Vec3) {
    let mut finite = instances.iter().map(|instance| instance.position).filter(|p| p.is_finite());
    let Some(first) = finite.next() else { return (Vec3::ZERO, Vec3::ZERO) };
    finite.fold((first, first), |(low, high), p| (low.min(p), high.max(p)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layout, place};

    /// Normalised device coordinates and depth of a point.
    fn seen(camera: &Camera, aspect: f32, p: Vec3) -> Vec3 {
        camera.clip_from_world(aspect).project_point3(p)
    }

    #[test]
    fn an_overlook_holds_the_whole_box() {
        for (low, high) in [([-15.0, 0.0, -15.0], [15.0, 2.0, 15.0]), ([0.0, 0.0, 0.0], [200.0, 2.0, 3.0])] {
            let (low, high) = (Vec3::from(low), Vec3::from(high));
            for aspect in [0.6, 1.78] {
                let camera = overlook(low, high, aspect);
                let corners = [low, high, Vec3::new(low.x, 0.0, high.z), Vec3::new(high.x, 2.0, low.z)];
                let widest = corners.map(|corner| seen(&camera, aspect, corner)).map(|p| p.x.abs().max(p.y.abs()));
                assert!(widest.iter().all(|&w| w < 0.95) && widest.iter().any(|&w| w > 0.6), "{widest:?}");
            }
        }
    }

    #[test]
    fn depth_runs_from_0_to_1_and_up_is_up() {
        let camera = Camera::orbit(Vec3::ZERO, 10.0, 0.0, 0.0);
        let near = seen(&camera, 1.5, camera.eye + Vec3::NEG_Z * camera.near_m);
        let far = seen(&camera, 1.5, camera.eye + Vec3::NEG_Z * camera.far_m);
        assert!(near.z.abs() < 1e-4 && (far.z - 1.0).abs() < 1e-4, "{near} {far}");
        assert!(seen(&camera, 1.5, Vec3::Y).y > 0.1 && seen(&camera, 1.5, Vec3::X).x > 0.1);
    }

    #[test]
    fn an_orbit_starts_in_front_and_turns_towards_plus_x() {
        let front = Camera::orbit(Vec3::Y, 4.0, 0.0, 0.0);
        assert!((front.eye - Vec3::new(0.0, 1.0, 4.0)).length() < 1e-5);
        let quarter = front.orbited(0.25);
        assert!((quarter.eye - Vec3::new(4.0, 1.0, 0.0)).length() < 1e-4, "{}", quarter.eye);
        let right = Camera::orbit(Vec3::Y, 4.0, std::f32::consts::FRAC_PI_2, 0.0);
        assert!((right.eye - quarter.eye).length() < 1e-4);
        assert!((front.orbited(7.0).eye - front.eye).length() < 1e-4);
    }

    #[test]
    fn looking_straight_down_is_a_valid_camera() {
        let above = Camera { eye: Vec3::Y * 5.0, target: Vec3::ZERO, fov_y_rad: 0.8, near_m: 0.1, far_m: 50.0 };
        assert!(above.clip_from_world(1.0).is_finite());
        let nowhere = Camera { target: above.eye, ..above };
        assert!(nowhere.clip_from_world(1.0).is_finite());
    }

    #[test]
    fn a_straight_path_ends_where_it_should() {
        let a = Camera::orbit(Vec3::ZERO, 4.0, 0.0, 0.2);
        let b = Camera::orbit(Vec3::ONE, 9.0, 1.0, 0.5);
        assert_eq!((a.towards(&b, 0.0), a.towards(&b, 1.0)), (a, b));
        assert_eq!(a.towards(&b, f32::NAN), a);
        assert!((a.towards(&b, 0.5).eye - (a.eye + b.eye) * 0.5).length() < 1e-5);
    }

    #[test]
    fn a_crowd_picture_has_its_horizon_in_the_upper_third_and_large_near_people() {
        let kinds = [Kind { footprint_m: 0.45, clip_durations_s: vec![1.0], ..Kind::default() }];
        for layout in [Layout::Grid, Layout::Disc, Layout::Ranks, Layout::Street] {
            for count in [1, 4, 100, 10_000] {
                let crowd = place(layout, count, 1.2, &kinds, &[], 1);
                let camera = framing_crowd(&crowd, &kinds, 16.0 / 9.0);
                let ahead = (camera.target - camera.eye) * Vec3::new(1.0, 0.0, 1.0);
                let horizon = seen(&camera, 16.0 / 9.0, camera.eye + ahead * 50.0).y;
                assert!((1.0 / 3.0..0.6).contains(&horizon), "{layout:?} {count}: {horizon}");
                let heights = crowd.iter().map(|person| {
                    let feet = seen(&camera, 16.0 / 9.0, person.position);
                    let head = seen(&camera, 16.0 / 9.0, person.position + Vec3::Y * 1.8);
                    let inside = feet.y > -1.0 && feet.x.abs() < 1.0 && head.y < 1.0 && feet.z < 1.0;
                    if inside { (head.y - feet.y) * 0.5 } else { 0.0 }
                });
                let (tallest, visible) = heights.fold((0.0_f32, 0), |(t, n), h| (t.max(h), n + usize::from(h > 0.0)));
                assert!(tallest > 0.12, "{layout:?} {count}: the tallest takes {tallest}");
                assert!(visible as f32 >= 0.4 * count as f32, "{layout:?} {count}: {visible} visible");
            }
        }
    }

    #[test]
    fn small_crowds_are_whole_and_fill_the_picture() {
        let kinds = [Kind { footprint_m: 0.45, clip_durations_s: vec![1.0], ..Kind::default() }];
        for layout in [Layout::Grid, Layout::Disc, Layout::Ranks, Layout::Street] {
            for (count, aspect) in [(1, 1.8), (2, 1.8), (5, 1.8), (20, 1.8), (64, 1.8), (5, 0.6), (64, 0.6)] {
                let crowd = place(layout, count, 1.2, &kinds, &[], 1);
                let camera = frame_crowd(&crowd, 1.8, aspect);
                let feet: Vec<Vec3> = crowd.iter().map(|one| one.position).collect();
                let Box2 { low, high, across } = box_of(&camera, aspect, &feet, 1.8);
                let place = format!("{layout:?} {count} at {aspect}: {low} to {high}, {across}");
                let allowed = if count <= SHOWN_WHOLE as u32 { 0.96 } else { 1.56 };
                assert!(low > -0.98 && high < 0.96 && across < allowed, "cut off: {place}");
                assert!(low < if aspect > 1.0 { -0.6 } else { -0.45 }, "empty foreground: {place}");
                assert!(high - low > 1.4 || across > 0.9, "small: {place}");
            }
        }
    }

    #[test]
    fn a_street_is_seen_from_the_side_of_those_who_come() {
        let kinds = [Kind { footprint_m: 0.45, clip_durations_s: vec![1.0], ..Kind::default() }];
        let eye_x = |layout| framing_crowd(&place(layout, 500, 1.2, &kinds, &[], 1), &kinds, 1.6).eye.x;
        assert!(eye_x(Layout::Street) < -0.5 && eye_x(Layout::Ranks) > 0.5 && eye_x(Layout::Grid) > 0.5);
    }

    #[test]
    fn strange_crowds_still_give_a_camera() {
        let crowd = crate::place(crate::Layout::Grid, 1, 1.0, &[Kind::default()], &[], 0);
        let odd = Instance { position: Vec3::NAN, ..crowd[0] };
        assert!(framing_crowd(&[odd], &[], f32::NAN).clip_from_world(1.0).is_finite());
        assert!(framing_crowd(&[], &[], 1.0).clip_from_world(1.0).is_finite());
    }
}
