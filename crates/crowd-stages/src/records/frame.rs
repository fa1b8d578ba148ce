//! What a frame is told and what it came to.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

/// What the stages need to know of a frame, a uniform of 240 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct FrameConfig {
    /// World to clip space, columns.
    pub clip_from_world: [[f32; 4]; 4],
    /// Six planes, inside is `dot(n, p) + d >= 0`, unit normals: left, right, bottom, top, near, far; far before near where depth is 1 near.
    pub planes: [[f32; 4]; 6],
    /// Camera position, metres.
    pub eye: [f32; 3],
    /// Pixels per unit of `radius / distance`: `viewport_height / (2 * tan(fov_y / 2))`.
    pub focal_px: f32,
    /// Seconds since start.
    pub time_s: f32,
    /// `1 / alpha` (Peng 2011 Eq. 1).
    pub inverse_alpha: f32,
    /// Vertices (or what `budget_in` says) for the whole frame: the paper's N.
    pub budget: u32,
    /// Instances in the buffer.
    pub instance_count: u32,
    /// [`Weight`] as a number.
    pub weight: u32,
    /// 1 when levels morph; filled in like `instance_count`.
    pub morph: u32,
    /// Depths, metres, from which [`crate::Technique::Discrete`] draws its second and its third level.
    pub lod_depths_m: [f32; 2],
    /// Projected area of the bounding sphere, px², below which [`crate::Technique::Bucketed`] may draw dots instead of the
    /// coarsest mesh ([`dot_area_px2`]); 0: never.
    pub dot_area_px2: f32,
    /// Where poses are held: metres from which they change four times a second; 0: `hold_px` says.
    pub hold_far_m: f32,
    /// Where poses are held: pixels by which a point of them may be late; 0 with `hold_far_m` 0: none is held.
    pub hold_px: f32,
    /// [`BudgetIn`] as a number.
    pub budget_in: u32,
    /// How much of the budget may be left over so that the water stays where it was ([`crate::cpu::fill_budget`]); 0: nothing.
    pub slack: u32,
    /// Bits of the water's height in the frame before ([`FillState::smooth_bits`](crate::FillState::smooth_bits)), 0: there was none; filled in like `instance_count` where
    /// it is 0.
    pub water_before_bits: u32,
    /// How dense the fog is: after d metres `exp(-d * fog_per_m)` of a colour is left; 0: none.
    pub fog_per_m: f32,
    /// Projected area of the bounding sphere, px², below which [`crate::Technique::Bucketed`] draws impostors where the crowd has them
    /// ([`dot_area_px2`]); up to [`crate::IMPOSTOR_FADE`] times as much they cross over from the coarsest mesh. 0: never.
    pub impostor_area_px2: f32,
}

impl FrameConfig {
    /// What a level takes of the budget.
    pub fn spent(&self, vertex_count: u32, triangle_count: u32) -> u32 {
        if self.budget_in == BudgetIn::Triangles as u32 { triangle_count } else { vertex_count }
    }

    /// The frame's uniform: planes from the matrix, pixels per radian from the field of view.
    ///
    /// `instance_count` is filled in by whoever holds the instances ([`crate::gpu::CrowdRenderer::encode`] and
    /// [`crate::cpu::run_selection`] set it themselves). An `alpha` below 1 or not finite counts as 1. There are no dots, no impostors,
    /// no fog, and levels follow every change: [`Self::with_usual_detail`] has what `crowdplay` shows.
    pub fn from_camera(view: &FrameView) -> Self {
        let half_height = libm::tanf(view.fov_y_rad * 0.5).max(1e-6);
        let focal_px = view.viewport_height_px / (2.0 * half_height);
        let alpha = if view.alpha.is_finite() { view.alpha.max(1.0) } else { 1.0 };
        Self {
            clip_from_world: view.clip_from_world.to_cols_array_2d(),
            planes: frustum_planes(&view.clip_from_world),
            eye: view.eye.to_array(),
            focal_px,
            time_s: view.time_s,
            inverse_alpha: 1.0 / alpha,
            budget: view.budget,
            instance_count: 0,
            weight: view.weight as u32,
            morph: 0,
            lod_depths_m: LOD_HEIGHTS_PX.map(|height_px| 1.8 * focal_px / height_px),
            dot_area_px2: 0.0,
            hold_far_m: 0.0,
            hold_px: 0.0,
            budget_in: BudgetIn::Vertices as u32,
            slack: 0,
            water_before_bits: 0,
            fog_per_m: 0.0,
            impostor_area_px2: 0.0,
        }
    }

    /// The same with what `crowdplay` does unless told otherwise: dots and impostors for those below [`STAND_IN_PX`], and a budget of which
    /// [`STEADY_PERCENT`] may be left over so that levels keep still.
    pub fn with_usual_detail(self) -> Self {
        let area_px2 = dot_area_px2(STAND_IN_PX);
        let slack = (f64::from(self.budget) * f64::from(STEADY_PERCENT / 100.0)) as u32;
        Self { dot_area_px2: area_px2, impostor_area_px2: area_px2, slack, ..self }
    }
}

/// Height below which somebody is drawn as dots or as their impostor in the usual detail, pixels.
pub const STAND_IN_PX: f32 = 12.0;

/// What may be left of the budget in the usual detail, percent of it.
pub const STEADY_PERCENT: f32 = 0.9;

/// Projected area of the bounding sphere of a character that is so many pixels high: its diameter is a tenth more.
pub fn dot_area_px2(height_px: f32) -> f32 {
    let radius_px = 0.55 * height_px;
    std::f32::consts::PI * radius_px * radius_px
}

/// Heights in pixels that somebody of 1.8 m has where [`crate::Technique::Discrete`] changes levels, unless it is told otherwise.
pub const LOD_HEIGHTS_PX: [f32; 2] = [200.0, 66.0];

/// What [`FrameConfig::from_camera`] is told of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrameView {
    /// World to clip space, Y up, x and y from -1 to 1. Depth is 0 near and 1 far (wgpu's convention), or 1 near and 0 far
    /// for a renderer with [`crate::gpu::RendererOptions::reverse_z`].
    pub clip_from_world: Mat4,
    /// Camera position, metres.
    pub eye: Vec3,
    /// Vertical field of view, radians.
    pub fov_y_rad: f32,
    /// Height of the picture, pixels.
    pub viewport_height_px: f32,
    /// Seconds since start.
    pub time_s: f32,
    /// Vertices for the whole frame: the paper's N. At most the renderer's [`crate::gpu::RendererOptions::max_vertices`]: what is more is left out where
    /// vertices are written beforehand (reformation, [`crate::Skinning::Compute`]), and [`crate::FrameTotals::overflow`] says so.
    pub budget: u32,
    /// The paper's alpha, at least 1; both papers use 3.
    pub alpha: f32,
    /// How an instance is weighed.
    pub weight: Weight,
}

/// Six inward planes with unit normals from a matrix with depth from 0 to 1: left, right, bottom, top, near, far; where depth is 1 near, the far
/// one before the near one, the same six.
fn frustum_planes(clip_from_world: &Mat4) -> [[f32; 4]; 6] {
    let row = |i| clip_from_world.row(i);
    let planes = [row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1), row(2), row(3) - row(2)];
    planes.map(|plane| {
        let length = plane.truncate().length();
        // An infinite far plane has no normal: it holds everything.
        if length > 1e-12 { (plane / length).to_array() } else { [0.0, 0.0, 0.0, f32::MAX] }
    })
}

/// What the budget counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum BudgetIn {
    /// Vertices, as the papers do.
    #[default]
    Vertices = 0,
    /// Triangles: what rasterisers are bound by. Only water filling counts them; Eq. 1 as printed shares vertices.
    Triangles = 1,
}

impl BudgetIn {
    /// The word for it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Vertices => "vertices",
            Self::Triangles => "triangles",
        }
    }
}

/// How Eq. 1 weighs an instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Weight {
    /// Peng 2011 Eq. 1: `A^(1/alpha)`, A the projected area of the bounding sphere.
    #[default]
    Area,
    /// Dong 2019 Eq. 1 (Peng & Cao 2012): `(alpha - 1) * (A / D) * P^(alpha - 1)`, raised to `1/alpha`.
    ///
    /// How we read the exponent: the count minimises the sum of `(A / D) * (P / k)^(alpha - 1)` over all instances with
    /// the counts adding up to N, where P is the vertex count of the instance's character at full detail. A Lagrange
    /// multiplier gives `k ~ ((alpha - 1) * (A / D) * P^(alpha - 1))^(1 / alpha)`. The factor `alpha - 1` is the same for
    /// all and cancels in the quotient, so we leave it out; at `alpha = 1` it would be 0 for everyone.
    AreaDistance,
    /// No share at all: pixels that a metre takes on the screen. Every instance gets the coarsest quantised level whose
    /// measured error is below one number of pixels, the same for all, as small as the budget allows
    /// ([`crate::cpu::fill_budget`]).
    Error,
}

/// What only drawing needs, a uniform of 48 bytes. The ray through a point of the picture, in normalised device coordinates,
/// is `ray_x * x + ray_y * y + ray_w`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct DrawConfig {
    /// Ray along the picture's x.
    pub ray_x: [f32; 3],
    /// Width of the target, pixels.
    pub width_px: f32,
    /// Ray along the picture's y, upwards.
    pub ray_y: [f32; 3],
    /// Height of the target, pixels.
    pub height_px: f32,
    /// Ray through the picture's centre.
    pub ray_w: [f32; 3],
    /// Side of a texture layer, texels.
    pub layer_side: f32,
}

impl DrawConfig {
    /// Rays from the matrix alone, by its rows x, y and w: inverting all of it loses digits on the far plane. Rays are zeros
    /// for a matrix without perspective.
    pub fn new(clip_from_world: &Mat4, width_px: u32, height_px: u32, layer_side: u32) -> Self {
        let row = |i| clip_from_world.row(i).truncate();
        let (a, b, c) = (row(0), row(1), row(3));
        let det = a.dot(b.cross(c));
        let inverse = if det.is_finite() && det != 0.0 { 1.0 / det } else { 0.0 };
        Self {
            ray_x: (b.cross(c) * inverse).to_array(),
            width_px: width_px as f32,
            ray_y: (c.cross(a) * inverse).to_array(),
            height_px: height_px as f32,
            ray_w: (a.cross(b) * inverse).to_array(),
            layer_side: layer_side as f32,
        }
    }
}

/// What marks besides the crowd show, a uniform of 144 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MarkConfig {
    /// Corners of a frustum in the world, metres, the fourth number 1: bit 0 of a corner's number is right, bit 1 up, bit 2 far.
    pub corners: [[f32; 4]; 8],
    /// [`crate::View`] as a number.
    pub view: u32,
    /// 1 when the levels are those of `choices`; else everyone is at full detail.
    pub has_choices: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
}

/// What a frame came to, 52 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct FrameTotals {
    /// Instances drawn: those whose sphere meets the frustum, less the occluded ones.
    pub visible_count: u32,
    /// Vertices drawn.
    pub vertex_count: u32,
    /// Triangles drawn.
    pub triangle_count: u32,
    /// Vertices (or what the budget counts) of the visible instances' coarsest levels: the least budget that draws all of them.
    pub min_vertex_count: u32,
    /// [`overflow`] bits.
    pub overflow: u32,
    /// Vertices of all visible instances at the levels chosen, drawn or not: what the vertex list must hold.
    pub needed_vertices: u32,
    /// Triangles of all visible instances at the levels chosen, drawn or not: what the index buffer must hold.
    pub needed_triangles: u32,
    /// Draws that draw anything.
    pub draw_count: u32,
    /// Vertices that Eq. 1 as printed comes to, clamped to what characters have; 0 where there is no budget.
    pub wanted_count: u32,
    /// Of [`Weight::Error`]: pixels that no error on the screen exceeds, full detail aside; else 0.
    pub threshold_px: f32,
    /// Instances whose sphere meets the frustum and that are not drawn because others hide them; 0 without occlusion culling.
    pub occluded_count: u32,
    /// Instances whose sphere does not meet the frustum, where those are culled.
    pub outside_count: u32,
    /// Instances of a simulator that were refused and are not drawn ([`crate::FeedState::refused_count`]).
    pub refused_count: u32,
}

/// Bits of [`FrameTotals::overflow`].
pub mod overflow {
    /// The coarsest levels alone exceed the budget.
    pub const BUDGET: u32 = 1;
    /// More vertices than the frame's vertex list holds; instances past the end are not drawn.
    pub const VERTICES: u32 = 2;
    /// More triangles than the frame's index buffer holds; instances past the end are not drawn.
    pub const TRIANGLES: u32 = 4;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn view() -> FrameView {
        let camera = glam::camera::rh::view::look_at_mat4(Vec3::new(3.0, 2.0, 9.0), Vec3::new(0.5, 1.0, -4.0), Vec3::Y);
        let projection = glam::camera::rh::proj::directx::perspective(0.9, 16.0 / 9.0, 0.1, 50.0);
        FrameView {
            clip_from_world: projection * camera,
            eye: Vec3::new(3.0, 2.0, 9.0),
            fov_y_rad: 0.9,
            viewport_height_px: 720.0,
            time_s: 0.0,
            budget: 1,
            alpha: 3.0,
            weight: Weight::Area,
        }
    }

    #[test]
    fn a_point_is_inside_the_planes_when_its_clip_coordinates_are_in_range() {
        let view = view();
        let config = FrameConfig::from_camera(&view);
        let (mut inside, mut outside) = (0, 0);
        for i in 0..4000 {
            let part = |step: i32, reach: f32| ((i * step % 101) as f32 / 50.0 - 1.0) * reach;
            let p = Vec3::new(part(7, 30.0), part(31, 15.0), part(53, 60.0));
            let clip = view.clip_from_world * p.extend(1.0);
            let distances = config.planes.map(|n| Vec3::new(n[0], n[1], n[2]).dot(p) + n[3]);
            let nearest = distances.iter().copied().fold(f32::MAX, f32::min);
            if nearest.abs() < 1e-3 {
                continue;
            }
            let in_range = clip.x.abs() <= clip.w && clip.y.abs() <= clip.w && clip.z >= 0.0 && clip.z <= clip.w;
            assert_eq!(nearest > 0.0, in_range, "{p}");
            *(if in_range { &mut inside } else { &mut outside }) += 1;
        }
        assert!(inside > 100 && outside > 100, "{inside} inside, {outside} outside");
    }

    #[test]
    fn a_sphere_at_the_focal_length_covers_its_own_radius_in_pixels() {
        let config = FrameConfig::from_camera(&view());
        // Half the picture's height is tan(fov / 2) at distance 1.
        let half_height = libm::tanf(0.45);
        assert!((config.focal_px * half_height - 360.0).abs() < 1e-2);
    }

    #[test]
    fn an_alpha_below_one_counts_as_one_and_an_infinite_far_plane_holds_everything() {
        for alpha in [0.0, -3.0, f32::NAN] {
            assert_eq!(FrameConfig::from_camera(&FrameView { alpha, ..view() }).inverse_alpha, 1.0);
        }
        let infinite = glam::camera::rh::proj::directx::perspective_infinite(0.9, 1.5, 0.1);
        let config = FrameConfig::from_camera(&FrameView { clip_from_world: infinite, ..view() });
        let far = Vec3::new(0.0, 0.0, -1e9);
        let holds = |config: &FrameConfig, p: Vec3| {
            config.planes.iter().skip(4).all(|plane| Vec3::new(plane[0], plane[1], plane[2]).dot(p) + plane[3] >= 0.0)
        };
        assert!(holds(&config, far) && !holds(&config, -far));
        let reversed = glam::camera::rh::proj::directx::perspective_infinite_reverse(0.9, 1.5, 0.1);
        let config = FrameConfig::from_camera(&FrameView { clip_from_world: reversed, ..view() });
        assert!(holds(&config, far) && !holds(&config, -far));
    }

    #[test]
    fn rays_go_through_the_points_they_belong_to() {
        let view = view();
        let draw = DrawConfig::new(&view.clip_from_world, 640, 360, 64);
        let direction = Vec3::from(draw.ray_x) * 0.3 + Vec3::from(draw.ray_y) * -0.7 + Vec3::from(draw.ray_w);
        let clip = view.clip_from_world * (view.eye + direction * 7.0).extend(1.0);
        assert!((clip.x / clip.w - 0.3).abs() < 1e-4 && (clip.y / clip.w + 0.7).abs() < 1e-4);
        assert_eq!(DrawConfig::new(&Mat4::ZERO, 1, 1, 1).ray_w, [0.0; 3]);
    }
}
