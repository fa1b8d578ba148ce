//! Where the sun's shadow maps lie: cascades over the part of the camera's view in which the crowd is.

use crate::{Cascade, DrawConfig, FrameConfig, ShadowConfig, dispatch::MAX_CASCADES};
use glam::{DMat3, DMat4, DVec3, Mat4, Vec3};

/// Towards the sun, unit length; `shaders/shared/light.wgsl` has the same.
pub const SUN_DIRECTION: [f32; 3] = [0.451_129, 0.701_757, 0.551_380];
/// Fewest and most texels a side of a shadow map.
const SIDES: [u32; 2] = [512, 2048];
/// Texels by which casters may be off: light looks at three by three of them, and bounds are of the worst point in the worst pose.
const CASTER_TEXELS: f64 = 2.0;
/// Nearest depth that a cascade begins at, metres.
const NEAREST_M: f64 = 0.5;
/// Farthest depth with shadows, metres.
const FARTHEST_M: f64 = 400.0;
/// How much the splits follow the logarithm; the rest is even.
const LOGARITHMIC: f64 = 0.8;
/// Walls may be higher than the crowd by this, metres.
const WALLS_M: f64 = 3.0;

/// Box around everyone in any pose, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrowdBounds {
    /// Least corner.
    pub low: Vec3,
    /// Greatest corner.
    pub high: Vec3,
}

impl Default for CrowdBounds {
    /// Holds nothing.
    fn default() -> Self {
        Self { low: Vec3::splat(f32::MAX), high: Vec3::splat(f32::MIN) }
    }
}

impl CrowdBounds {
    /// Takes a sphere in.
    pub fn add(&mut self, center: Vec3, radius: f32) {
        self.low = self.low.min(center - radius);
        self.high = self.high.max(center + radius);
    }
}

/// Texels a side of the maps for a picture of that height: about as fine as its pixels, a power of two.
pub fn shadow_side(height_px: u32) -> u32 {
    (height_px.saturating_mul(5) / 4).next_power_of_two().clamp(SIDES[0], SIDES[1])
}

/// Cascades of a frame: `count` of them, at most four, share the depths in which the crowd is seen.
///
/// Each map is a square around the sphere that holds its part of the view, so its size does not change while the camera turns,
/// and its place goes in steps of whole texels: shadows of what stands still do not crawl. Depths are rounded to steps of a
/// quarter of a doubling, so that a crowd that moves seldom changes them.
///
/// Paper: Zhang et al. 2006 (parallel-split shadow maps) for the splits, Valient 2008 (stable cascades).
pub fn fit_cascades(config: &FrameConfig, draw: &DrawConfig, bounds: &CrowdBounds, count: u32) -> ShadowConfig {
    let mut shadow = ShadowConfig::default();
    let rows = Mat4::from_cols_array_2d(&config.clip_from_world);
    let depth_of = |p: Vec3| f64::from(rows.row(3).dot(p.extend(1.0)));
    let corner = |c: usize| {
        let pick = |axis: usize| if c & (1 << axis) != 0 { bounds.high[axis] } else { bounds.low[axis] };
        Vec3::new(pick(0), pick(1), pick(2))
    };
    let depths = (0..8).map(|c| depth_of(corner(c)));
    let (first, last) = depths.fold((f64::MAX, f64::MIN), |(low, high), d| (low.min(d), high.max(d)));
    // Nobody is there, the camera has no perspective, or everyone is behind it.
    if bounds.low.x > bounds.high.x || Vec3::from(draw.ray_w).length_squared() == 0.0 || last <= NEAREST_M {
        return shadow;
    }
    let first = rounded(first.clamp(NEAREST_M, FARTHEST_M), f64::floor);
    let last = rounded(last.clamp(NEAREST_M, FARTHEST_M), f64::ceil).max(first * 1.5);
    let side = shadow_side(draw.height_px as u32);
    let count = count.min(MAX_CASCADES);
    let split = |number: u32| {
        let share = f64::from(number) / f64::from(count);
        let (even, doubling) = (first + (last - first) * share, first * libm::pow(last / first, share));
        even + (doubling - even) * LOGARITHMIC
    };
    let world_height = f64::from(bounds.high.y - bounds.low.y) + WALLS_M;
    for number in 0..count {
        let (center, radius) = sphere_of(config, draw, split(number), split(number + 1));
        shadow.cascades[number as usize] = cascade(center, radius, world_height, side);
    }
    shadow.side = side;
    shadow.cascade_count = count;
    shadow.floor_m = bounds.low.y;
    shadow
}

/// To a quarter of a doubling.
fn rounded(depth: f64, round: fn(f64) -> f64) -> f64 {
    libm::exp2(round(libm::log2(depth) * 4.0) / 4.0)
}

/// The smallest sphere around the view between two depths whose centre is on the middle ray.
fn sphere_of(config: &FrameConfig, draw: &DrawConfig, near: f64, far: f64) -> (DVec3, f64) {
    let ray = |r: [f32; 3]| Vec3::from(r).as_dvec3();
    let (x, y, w) = (ray(draw.ray_x), ray(draw.ray_y), ray(draw.ray_w));
    // Half of the view's width at depth 1.
    let aside = (x + y).length();
    let along = w.length();
    let best = 0.5 * (near + far) * (1.0 + aside * aside / (along * along));
    let middle = best.clamp(near, far);
    let reach = |depth: f64| libm::hypot((depth - middle) * along, depth * aside);
    let radius = reach(near).max(reach(far));
    // In steps, so that rounding does not change a texel's size from frame to frame.
    (Vec3::from(config.eye).as_dvec3() + w * middle, (radius * 16.0).ceil() / 16.0)
}

fn cascade(center: DVec3, radius: f64, world_height: f64, side: u32) -> Cascade {
    let towards = Vec3::from(SUN_DIRECTION).as_dvec3().normalize();
    let right = DVec3::Y.cross(towards).normalize();
    let light_from_world = DMat3::from_cols(right, towards.cross(right), towards).transpose();
    let side = f64::from(side);
    // Two texels more for the filter.
    let half = radius * side / (side - 4.0);
    let texel = 2.0 * half / side;
    let snapped = (light_from_world * center / texel).floor() * texel;
    // From above everyone who may throw a shadow into the sphere to its far side.
    let above = radius + world_height / towards.y;
    // Whoever is in the square finds the map deep enough: the ground under the view's sphere and what is built into it.
    let range = above + 2.0 * radius + world_height;
    let rows = [
        light_from_world.row(0).extend(-snapped.x) / half,
        light_from_world.row(1).extend(-snapped.y) / half,
        (-light_from_world.row(2)).extend(snapped.z + above) / range,
        glam::DVec4::W,
    ];
    let clip_from_world = DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose().as_mat4();
    Cascade {
        clip_from_world: clip_from_world.to_cols_array_2d(),
        texel_m: texel as f32,
        half_m: half as f32,
        details_per_m: (1.0 / (CASTER_TEXELS * texel)) as f32,
        depth_per_m: (1.0 / range) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FrameView, Weight};

    fn config(eye: Vec3, target: Vec3) -> (FrameConfig, DrawConfig) {
        let view = glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y);
        let clip_from_world = glam::camera::rh::proj::directx::perspective(0.8, 16.0 / 9.0, 0.1, 500.0) * view;
        let view = FrameView {
            clip_from_world,
            eye,
            fov_y_rad: 0.8,
            viewport_height_px: 720.0,
            time_s: 0.0,
            budget: 1,
            alpha: 3.0,
            weight: Weight::Area,
        };
        (FrameConfig::from_camera(&view), DrawConfig::new(&clip_from_world, 1280, 720, 64))
    }

    fn bounds() -> CrowdBounds {
        let mut bounds = CrowdBounds::default();
        bounds.add(Vec3::new(-40.0, 1.0, -40.0), 1.0);
        bounds.add(Vec3::new(40.0, 1.0, 40.0), 1.0);
        bounds
    }

    fn at(cascade: &Cascade, p: Vec3) -> Vec3 {
        Mat4::from_cols_array_2d(&cascade.clip_from_world).transform_point3(p)
    }

    #[test]
    fn every_depth_of_the_view_is_in_a_cascade_and_near_ones_are_finer() {
        let (config, draw) = config(Vec3::new(3.0, 1.7, 30.0), Vec3::new(0.0, 1.0, 0.0));
        let shadow = fit_cascades(&config, &draw, &bounds(), 4);
        assert_eq!(shadow.cascade_count, 4);
        for step in 0..200 {
            let depth = 0.5 * libm::powf(140.0, step as f32 / 200.0);
            for (x, y) in [(0.0, 0.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
                let ray = Vec3::from(draw.ray_x) * x + Vec3::from(draw.ray_y) * y + Vec3::from(draw.ray_w);
                let p = Vec3::from(config.eye) + ray * depth;
                let holds = |c: &Cascade| at(c, p).truncate().abs().max_element() < 1.0 && at(c, p).z < 1.0;
                assert!(shadow.cascades.iter().any(holds), "{p} at {depth} m");
            }
        }
        let texels: Vec<f32> = shadow.cascades.iter().map(|c| c.texel_m).collect();
        assert!(texels.windows(2).all(|w| w[0] < w[1]) && texels[0] < 0.03, "{texels:?}");
    }

    #[test]
    fn a_camera_that_moves_and_turns_moves_the_maps_by_whole_texels() {
        let still = Vec3::new(1.0, 0.0, 2.0);
        let place = |eye: Vec3, target: Vec3| {
            let (config, draw) = config(eye, target);
            let shadow = fit_cascades(&config, &draw, &bounds(), 3);
            let c = shadow.cascades[1];
            (at(&c, still).truncate() * shadow.side as f32 * 0.5, c.texel_m)
        };
        let (first, texel) = place(Vec3::new(3.0, 1.7, 30.0), Vec3::new(0.0, 1.0, 0.0));
        for step in 1..40 {
            let part = step as f32 * 0.013;
            let (moved, size) = place(Vec3::new(3.0 + part, 1.7, 30.0 - 2.0 * part), Vec3::new(part, 1.0, part));
            assert_eq!(size, texel);
            let apart = moved - first;
            assert!((apart - apart.round()).abs().max_element() < 0.02, "{apart}");
        }
    }

    /// What `place_in` of `shaders/shared/shadow.wgsl` makes of six numbers of a map.
    fn as_the_shader(cascade: &Cascade, p: Vec3) -> Vec3 {
        let towards = Vec3::from(SUN_DIRECTION).normalize();
        let across = Vec3::Y.cross(towards).normalize();
        let from_sun = Vec3::new(p.dot(across), p.dot(towards.cross(across)), p.dot(towards));
        let scale = Vec3::new(1.0 / cascade.half_m, 1.0 / cascade.half_m, -cascade.depth_per_m);
        from_sun * scale + Mat4::from_cols_array_2d(&cascade.clip_from_world).w_axis.truncate()
    }

    #[test]
    fn six_numbers_of_a_map_say_what_its_matrix_says() {
        let (config, draw) = config(Vec3::new(3.0, 1.7, 30.0), Vec3::new(0.0, 1.0, 0.0));
        let shadow = fit_cascades(&config, &draw, &bounds(), 4);
        for c in &shadow.cascades {
            for p in [Vec3::ZERO, Vec3::new(40.0, 2.0, -35.0), Vec3::new(-7.0, 0.3, 12.0)] {
                let apart = at(c, p) - as_the_shader(c, p);
                assert!(apart.truncate().length() * 0.5 * (shadow.side as f32) < 0.01, "{apart} of half a map");
                assert!(apart.z.abs() < 1e-6, "{apart} of a map's depth");
            }
            let other = Cascade { depth_per_m: c.depth_per_m * 1.01, ..*c };
            assert!((at(c, bounds().low) - as_the_shader(&other, bounds().low)).z.abs() > 1e-6);
        }
    }

    #[test]
    fn maps_are_about_as_fine_as_the_picture() {
        assert_eq!([180, 360, 540, 720, 1080, 2160].map(shadow_side), [512, 512, 1024, 1024, 2048, 2048]);
    }

    #[test]
    fn who_is_higher_throws_a_shadow_that_ends_below_and_nobody_means_no_cascade() {
        let (config, draw) = config(Vec3::new(3.0, 1.7, 30.0), Vec3::new(0.0, 1.0, 0.0));
        let shadow = fit_cascades(&config, &draw, &bounds(), 1);
        let c = &shadow.cascades[0];
        let foot = Vec3::new(2.0, 0.0, 5.0);
        let head = foot + Vec3::from(SUN_DIRECTION) * 3.0;
        let (foot, head) = (at(c, foot), at(c, head));
        assert!(foot.truncate().distance(head.truncate()) < 1e-4 && head.z < foot.z && head.z > 0.0);
        assert_eq!(fit_cascades(&config, &draw, &CrowdBounds::default(), 4).cascade_count, 0);
    }
}
