//! What is behind the people: the sky's gradient and the ground with its grid. The same formulas in WGSL.
//!
//! The ray of a pixel comes from `clip_from_world` alone, without inverting the 4x4 matrix (which loses digits on the far
//! plane). With a, b, c the first three components of the matrix's rows x, y and w, and ndc in -1..1, y up:
//!
//! ```text
//! ndc   = ((px.x + 0.5) / width * 2 - 1, 1 - (px.y + 0.5) / height * 2)       (pixel centres; frag_coord.xy has the 0.5)
//! det   = dot(a, cross(b, c))
//! rx    = cross(b, c) / det;  ry = cross(c, a) / det;  rw = cross(a, b) / det
//! d     = rx * ndc.x + ry * ndc.y + rw                                        (ray direction; eye + t * d has clip w = t)
//! ```
//!
//! Sky (depth stays 1):
//!
//! ```text
//! up    = sqrt(clamp(normalize(d).y, 0, 1))
//! sky   = mix(SKY_HORIZON, SKY_ZENITH, up)
//! ```
//!
//! Ground, where `t = (GROUND_Y_M - eye.y) / d.y` is positive (no ground where d.y = 0):
//!
//! ```text
//! p     = eye + t * d
//! dx    = rx * (2 / width);  dy = ry * (-2 / height)                          (change of d to the next pixel)
//! px    = t * (dx - d * (dx.y / d.y));  py = t * (dy - d * (dy.y / d.y))       (change of p to the next pixel)
//! foot  = max(max(abs(px.xz), abs(py.xz)), 1e-4)                              (footprint, metres, per axis)
//! stripes(u, foot, width) = clamp((edge(u + foot / 2) - edge(u - foot / 2)) / foot, 0, 1)
//!         with edge(v) = floor(v) * width + min(v - floor(v), width)          (integral of a line of `width` at each whole v)
//! lines(p, foot, period, width) = 1 - (1 - sx) * (1 - sz)
//!         with s = stripes(p / period + width / period / 2, foot / period, width / period) for x and z
//! line  = max(LINE_STRENGTH * lines(p.xz, foot, 1, LINE_WIDTH_M), lines(p.xz, foot, 10, WIDE_LINE_WIDTH_M))
//! near  = exp(-length(p - eye) / FADE_M)
//! ground= mix(SKY_HORIZON, mix(GROUND, GROUND_LINE, line), near)
//! clip  = clip_from_world * (p, 1)
//! depth = min(clip.z / clip.w, 0.99999994)                                    (tested `less`, written)
//! ```

use glam::{Vec2, Vec3};
use rayon::prelude::*;

use crate::light;
use crate::srgb::encode_rgb;
use crate::{Target, View};

/// Largest depth below 1: ground beyond the far plane is still drawn.
pub(crate) const FARTHEST: f32 = 0.999_999_94;

/// The view rays of all pixels, affine in normalised device coordinates.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rays {
    rx: Vec3,
    ry: Vec3,
    rw: Vec3,
}

impl Rays {
    /// `None` for a matrix without perspective (orthographic or singular): its rays do not meet in the eye.
    pub(crate) fn new(view: &View) -> Option<Self> {
        let m = &view.clip_from_world;
        let (a, b, c) = (m.row(0).truncate(), m.row(1).truncate(), m.row(3).truncate());
        let det = a.dot(b.cross(c));
        if !det.is_finite() || det == 0.0 {
            return None;
        }
        Some(Self { rx: b.cross(c) / det, ry: c.cross(a) / det, rw: a.cross(b) / det })
    }

    pub(crate) fn direction(&self, ndc: Vec2) -> Vec3 {
        self.rx * ndc.x + self.ry * ndc.y + self.rw
    }
}

/// Centre of a pixel in normalised device coordinates, y up.
pub(crate) fn ndc_of_pixel(x: u32, y: u32, width: u32, height: u32) -> Vec2 {
    Vec2::new((x as f32 + 0.5) / width as f32 * 2.0 - 1.0, 1.0 - (y as f32 + 0.5) / height as f32 * 2.0)
}

/// Fills the target with the sky gradient and resets depth to 1. Without perspective all of it is the horizon's colour.
pub fn draw_sky(target: &mut Target, view: &View) {
    target.depth.fill(1.0);
    let (width, height) = (target.width, target.height);
    let Some(rays) = Rays::new(view) else {
        target.color.fill(encode_rgb(Vec3::from(light::SKY_HORIZON)));
        return;
    };
    target.color.par_chunks_mut(width.max(1) as usize).enumerate().for_each(|(y, row)| {
        for (x, pixel) in row.iter_mut().enumerate() {
            let d = rays.direction(ndc_of_pixel(x as u32, y as u32, width, height));
            *pixel = encode_rgb(sky_color(d));
        }
    });
}

/// Linear sky colour towards `d` (any length).
pub fn sky_color(d: Vec3) -> Vec3 {
    let up = d.normalize_or_zero().y.clamp(0.0, 1.0).sqrt();
    light::mix(Vec3::from(light::SKY_HORIZON), Vec3::from(light::SKY_ZENITH), up)
}

/// Draws the ground plane with a grid that fades with distance, depth-tested; writes depth. Nothing without perspective.
pub fn draw_ground(target: &mut Target, view: &View) {
    let (width, height) = (target.width, target.height);
    let Some(rays) = Rays::new(view) else { return };
    let dx = rays.rx * (2.0 / width as f32);
    let dy = rays.ry * (-2.0 / height as f32);
    let stride = width.max(1) as usize;
    let rows = target.color.par_chunks_mut(stride).zip(target.depth.par_chunks_mut(stride)).enumerate();
    rows.for_each(|(y, (colors, depths))| {
        for (x, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            let d = rays.direction(ndc_of_pixel(x as u32, y as u32, width, height));
            let t = (light::GROUND_Y_M - view.eye.y) / d.y;
            if !(t > 0.0 && t.is_finite()) {
                continue;
            }
            let p = view.eye + d * t;
            let clip = view.clip_from_world * p.extend(1.0);
            let z = (clip.z / clip.w).min(FARTHEST);
            if z >= *depth || !(0.0..=1.0).contains(&z) {
                continue;
            }
            let px = (dx - d * (dx.y / d.y)) * t;
            let py = (dy - d * (dy.y / d.y)) * t;
            let footprint = Vec2::new(px.x.abs().max(py.x.abs()).max(1e-4), px.z.abs().max(py.z.abs()).max(1e-4));
            *color = encode_rgb(ground_color(Vec2::new(p.x, p.z), footprint, (p - view.eye).length()));
            *depth = z;
        }
    });
}

/// Linear ground colour at `p` (x and z, metres), averaged over `footprint` (metres an axis), `distance` metres from the eye.
pub fn ground_color(p: Vec2, footprint: Vec2, distance: f32) -> Vec3 {
    let narrow = lines(p, footprint, 1.0, light::LINE_WIDTH_M);
    let wide = lines(p, footprint, 10.0, light::WIDE_LINE_WIDTH_M);
    let line = (light::LINE_STRENGTH * narrow).max(wide);
    let near = libm::expf(-distance / light::FADE_M);
    let ground = light::mix(Vec3::from(light::GROUND), Vec3::from(light::GROUND_LINE), line);
    light::mix(Vec3::from(light::SKY_HORIZON), ground, near)
}

/// Share of the footprint covered by lines of `width` each `period`, both in metres, along both axes.
fn lines(p: Vec2, footprint: Vec2, period: f32, width: f32) -> f32 {
    let width = width / period;
    let x = stripes(p.x / period + width / 2.0, footprint.x / period, width);
    let z = stripes(p.y / period + width / 2.0, footprint.y / period, width);
    1.0 - (1.0 - x) * (1.0 - z)
}

/// Share of [u - foot/2, u + foot/2] within [n, n + width] for any whole n.
fn stripes(u: f32, foot: f32, width: f32) -> f32 {
    let edge = |v: f32| v.floor() * width + (v - v.floor()).min(width);
    ((edge(u + foot / 2.0) - edge(u - foot / 2.0)) / foot).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view_from(eye: Vec3, target: Vec3) -> View {
        let camera = glam::camera::rh::view::look_at_mat4(eye, target, Vec3::Y);
        let clip = glam::camera::rh::proj::directx::perspective(1.0, 4.0 / 3.0, 0.1, 500.0);
        View { clip_from_world: clip * camera, eye }
    }

    #[test]
    fn rays_go_through_the_pixels_they_belong_to() {
        let view = view_from(Vec3::new(3.0, 2.0, 9.0), Vec3::new(0.5, 1.0, -4.0));
        let rays = Rays::new(&view).expect("perspective");
        for (x, y) in [(0, 0), (13, 5), (39, 29)] {
            let ndc = ndc_of_pixel(x, y, 40, 30);
            let clip = view.clip_from_world * (view.eye + rays.direction(ndc) * 7.0).extend(1.0);
            assert!((clip.w - 7.0).abs() < 1e-3);
            assert!((clip.x / clip.w - ndc.x).abs() < 1e-4 && (clip.y / clip.w - ndc.y).abs() < 1e-4);
        }
    }

    #[test]
    fn ground_is_below_the_horizon_and_sky_above_it() {
        let view = view_from(Vec3::new(0.0, 1.7, 0.0), Vec3::new(0.0, 1.7, -10.0));
        let mut target = Target::new(40, 30, [0, 0, 0, 255]);
        draw_sky(&mut target, &view);
        let sky_only = target.clone();
        draw_ground(&mut target, &view);
        for y in 0..30 {
            for x in 0..40 {
                let i = y * 40 + x;
                assert_eq!(target.depth[i] < 1.0, y >= 15, "pixel {x} {y}");
                assert_eq!(target.color[i] == sky_only.color[i], y < 15, "pixel {x} {y}");
            }
        }
        assert!(target.depth[29 * 40] < target.depth[20 * 40], "nearer ground has less depth");
    }

    #[test]
    fn stripes_integrate_to_their_width_over_a_whole_period() {
        for i in 0..20 {
            let u = i as f32 * 0.37 - 3.0;
            assert!((stripes(u, 1.0, 0.25) - 0.25).abs() < 1e-5);
        }
        assert_eq!(stripes(0.1, 0.01, 0.25), 1.0);
        assert_eq!(stripes(0.6, 0.01, 0.25), 0.0);
    }

    #[test]
    fn without_perspective_there_is_no_ground_and_no_panic() {
        let view = View { clip_from_world: glam::Mat4::ZERO, eye: Vec3::ZERO };
        let mut target = Target::new(3, 2, [1, 2, 3, 255]);
        draw_sky(&mut target, &view);
        let before = target.clone();
        draw_ground(&mut target, &view);
        assert_eq!(target, before);
    }
}
