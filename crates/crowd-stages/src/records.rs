//! Records of the frame: `repr(C)`, no padding surprises; the same structs stand in `shaders/shared/`.

use bytemuck::{Pod, Zeroable};
use glam::{Mat4, Vec3};

/// One individual, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct InstanceRecord {
    /// Feet, metres.
    pub position: [f32; 3],
    /// 0 faces +Z; positive turns towards +X.
    pub yaw_rad: f32,
    /// Size factor.
    pub scale: f32,
    /// Index into the character records.
    pub character: u32,
    /// Index into the clip records (global).
    pub clip: u32,
    /// Start time within the clip, seconds.
    pub phase_s: f32,
}

/// What the stages need to know of a frame, a uniform of 224 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct FrameConfig {
    /// World to clip space, columns.
    pub clip_from_world: [[f32; 4]; 4],
    /// Six planes, inside is `dot(n, p) + d >= 0`, unit normals: left, right, bottom, top, near, far.
    pub planes: [[f32; 4]; 6],
    /// Camera position, metres.
    pub eye: [f32; 3],
    /// Pixels per unit of `radius / distance`: `viewport_height / (2 * tan(fov_y / 2))`.
    pub focal_px: f32,
    /// Seconds since start.
    pub time_s: f32,
    /// `1 / alpha` (Peng 2011 Eq. 1).
    pub inverse_alpha: f32,
    /// Vertices for the whole frame: the paper's N.
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
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
    /// Zero.
    pub reserved_c: u32,
}

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
    /// World to clip space, depth 0 to 1, Y up (wgpu's convention).
    pub clip_from_world: Mat4,
    /// Camera position, metres.
    pub eye: Vec3,
    /// Vertical field of view, radians.
    pub fov_y_rad: f32,
    /// Height of the picture, pixels.
    pub viewport_height_px: f32,
    /// Seconds since start.
    pub time_s: f32,
    /// Vertices for the whole frame: the paper's N.
    pub budget: u32,
    /// The paper's alpha, at least 1; both papers use 3.
    pub alpha: f32,
    /// How an instance is weighed.
    pub weight: Weight,
}

impl FrameConfig {
    /// The frame's uniform: planes from the matrix, pixels per radian from the field of view.
    ///
    /// `instance_count` is filled in by whoever holds the instances ([`crate::gpu::CrowdRenderer::encode`] and
    /// [`crate::cpu::run_selection`] set it themselves). An `alpha` below 1 or not finite counts as 1.
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
            reserved_a: 0,
            reserved_b: 0,
            reserved_c: 0,
        }
    }
}

/// Six inward planes with unit normals from a matrix with depth 0 to 1: left, right, bottom, top, near, far.
fn frustum_planes(clip_from_world: &Mat4) -> [[f32; 4]; 6] {
    let row = |i| clip_from_world.row(i);
    let planes = [row(3) + row(0), row(3) - row(0), row(3) + row(1), row(3) - row(1), row(2), row(3) - row(2)];
    planes.map(|plane| {
        let length = plane.truncate().length();
        // An infinite far plane has no normal: it holds everything.
        if length > 1e-12 { (plane / length).to_array() } else { [0.0, 0.0, 0.0, f32::MAX] }
    })
}

/// Result of `cull_instances`, 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct CullRecord {
    /// 1 when the bounding sphere meets the frustum.
    pub visible: u32,
    /// The instance's weight; 0 when culled.
    pub weight: f32,
    /// Projected area of the bounding sphere, px².
    pub area_px2: f32,
    /// Distance of the sphere's centre to the camera, metres.
    pub distance_m: f32,
}

/// Result of `select_lod` and `fit_budget`, 8 bytes. Zeros when culled.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct LodChoice {
    /// Vertices: k.
    pub vertex_count: u32,
    /// Triangles: q(k).
    pub triangle_count: u32,
}

/// Result of `sum_weights`, completed by `fit_budget`, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct WeightSums {
    /// Sum of the weights: the denominator of Eq. 1.
    pub weight: f32,
    /// Vertices of the visible instances' coarsest levels, saturating.
    pub min_vertex_count: u32,
    /// Visible instances.
    pub visible_count: u32,
    /// Vertices that Eq. 1 as printed comes to, saturating.
    pub wanted_count: u32,
    /// Share of what was wanted above the coarsest levels that the budget allows, in units of 2^-32.
    /// Meaningful only when `is_scaled` is 1.
    pub share: u32,
    /// 1 when what was wanted exceeds the budget.
    pub is_scaled: u32,
    /// Bits of the water's height that `fill_budget` found, vertices a unit of weight; [`Weight::Error`]: one over pixels.
    pub water_bits: u32,
    /// Zero.
    pub reserved: u32,
}

/// Where an instance's part of the frame's vertex list and index buffer starts, 8 bytes: result of `scan_counts`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct InstanceBase {
    /// Vertices selected for all instances before this one.
    pub vertex_base: u32,
    /// Triangles selected for all instances before this one.
    pub triangle_base: u32,
}

/// What the frame's buffers hold, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct Capacities {
    /// Entries of the vertex list.
    pub vertex_count: u32,
    /// Triangles of the index buffer.
    pub triangle_count: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
}

/// Arguments of an indexed indirect draw, 20 bytes; the layout is wgpu's.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct DrawArgs {
    /// Three a triangle.
    pub index_count: u32,
    /// Of a bucket: its instances; else 1.
    pub instance_count: u32,
    /// First in the index buffer.
    pub first_index: u32,
    /// Always 0.
    pub base_vertex: i32,
    /// Of a bucket: its first entry of the sorted list; else 0.
    pub first_instance: u32,
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

/// What a frame came to, 48 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct FrameTotals {
    /// Instances drawn: those whose sphere meets the frustum, less the occluded ones.
    pub visible_count: u32,
    /// Vertices drawn.
    pub vertex_count: u32,
    /// Triangles drawn.
    pub triangle_count: u32,
    /// Vertices of the visible instances' coarsest levels: the least budget that draws all of them.
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
}

/// Where the search of `fill_budget` has got to, 96 bytes. Heights are bits of floats, vertices a unit of weight.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct FillState {
    /// Greatest height known to fit.
    pub low_bits: u32,
    /// Least height known not to fit, or the same.
    pub high_bits: u32,
    /// Vertices at the former.
    pub low_count: u32,
    /// Passes done.
    pub pass_number: u32,
    /// Heights to try next, rising; in the first pass the last is that of Eq. 1.
    pub candidates: [u32; dispatch::FILL_CANDIDATES as usize],
    /// Zeros.
    pub reserved: [u32; 4],
}

/// A level of the depth pyramid, 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct PyramidLevel {
    /// Its first number in the pyramid's buffer.
    pub offset: u32,
    /// Numbers a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Zero.
    pub reserved: u32,
}

/// The depth pyramid's shape, a uniform of 272 bytes. Level `k` has one number for each block of `2^(k + 1)` pixels a side,
/// as far as the picture goes, so that a pixel's block is found by shifting whatever the size.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct PyramidConfig {
    /// Width of the picture, pixels.
    pub width_px: u32,
    /// Height of the picture, pixels.
    pub height_px: u32,
    /// Samples a pixel.
    pub sample_count: u32,
    /// Levels; the last is one number.
    pub level_count: u32,
    /// The finest first.
    pub levels: [PyramidLevel; dispatch::PYRAMID_LEVELS as usize],
}

impl PyramidConfig {
    /// The pyramid over a picture of at least one pixel and at most 2^16 a side.
    pub fn new(width_px: u32, height_px: u32, sample_count: u32) -> Self {
        let mut config = Self { width_px, height_px, sample_count, ..Self::default() };
        let (mut width, mut height, mut offset) = (width_px, height_px, 0);
        for level in &mut config.levels {
            (width, height) = (width.div_ceil(2), height.div_ceil(2));
            *level = PyramidLevel { offset, width, height, reserved: 0 };
            offset += width * height;
            config.level_count += 1;
            if width == 1 && height == 1 {
                break;
            }
        }
        config
    }

    /// Numbers of all levels.
    pub fn number_count(&self) -> u32 {
        self.levels.iter().map(|level| level.width * level.height).sum()
    }
}

/// Which level `build_pyramid` makes, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct PyramidStep {
    /// The level.
    pub level: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
    /// Zero.
    pub reserved_c: u32,
}

/// Who waits for the second phase of occlusion culling, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct SightTally {
    /// Vertices of their coarsest levels, saturating.
    pub hidden_min_count: u32,
    /// Instances.
    pub hidden_count: u32,
}

/// What is known of an instance's sight: words of the `seen` buffer, after the number of instances they are valid for.
pub mod sight {
    /// Not hidden by the newest pyramid.
    pub const SEEN: u32 = 1;
    /// Hidden by the newest pyramid.
    pub const HIDDEN: u32 = 2;
    /// Drawn in the newest frame, whether then hidden or not.
    pub const DRAWN: u32 = 4;
}

/// A shadow map of the sun, 80 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct Cascade {
    /// World to the map: x and y -1 to 1, z 0 nearest to the sun, columns.
    pub clip_from_world: [[f32; 4]; 4],
    /// Side of a texel, metres.
    pub texel_m: f32,
    /// Half of the map's side, metres.
    pub half_m: f32,
    /// One over the error, metres, that its casters may have.
    pub details_per_m: f32,
    /// Zero.
    pub reserved: u32,
}

/// The sun's shadow maps, a uniform of 336 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct ShadowConfig {
    /// The finest first.
    pub cascades: [Cascade; dispatch::MAX_CASCADES as usize],
    /// How many there are.
    pub cascade_count: u32,
    /// Height that no shadow falls below, metres.
    pub floor_m: f32,
    /// Texels a side of each map.
    pub side: u32,
    /// Zero.
    pub reserved: u32,
}

/// Whose casters `select_casters` selects, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct CascadeStep {
    /// Number of the cascade.
    pub cascade: u32,
    /// 1 where the levels that the camera sees are known.
    pub has_choices: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
}

/// What [`crate::Technique::Discrete`] is told of the crowd, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct DiscreteConfig {
    /// Half the diagonal of the largest character's box, metres.
    pub half_diagonal_m: f32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
    /// Zero.
    pub reserved_c: u32,
}

/// A corner of a dot, 48 bytes, in the words of [`crowd_pack::VertexRecord`]; goes to the GPU as a vertex buffer. The three
/// corners of a dot differ in their number alone.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct DotCorner {
    /// Of the vertex that the dot's middle follows, bind pose, metres.
    pub position: [f32; 3],
    /// Square roots of the linear base colour; the last is 0 where light does not change it.
    pub color: [u8; 4],
    /// Half the width and half the height of the triangle, metres.
    pub half_size_m: [f32; 2],
    /// 0, 1 or 2; 3, 4 or 5 of one that stands on its head.
    pub number: u32,
    /// Zero.
    pub reserved: u32,
    /// Joints of the vertex.
    pub joints: [u32; 2],
    /// Its weights.
    pub weights: [u32; 2],
}

/// A quantised level of a character: what one indirect draw draws, 20 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct BucketRecord {
    /// Vertices of the level; indices are below.
    pub vertex_count: u32,
    /// Triangles of the level.
    pub triangle_count: u32,
    /// First index, in the index buffer of that width.
    pub first_index: u32,
    /// Vertices of the next coarser quantised level; its own of the coarsest.
    pub coarser_vertex_count: u32,
    /// The character's first vertex among all.
    pub vertex_offset: u32,
}

/// Where a vertex comes from when its level comes, 48 bytes: the vertex that the next coarser quantised level has in its place
/// (itself where the coarsest level has it).
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct OriginRecord {
    /// Bind-space position, metres.
    pub position: [f32; 3],
    /// As in [`crowd_pack::VertexRecord`].
    pub normal_oct: u32,
    /// Texture coordinates.
    pub uv: [f32; 2],
    /// Linear RGBA8.
    pub color: u32,
    /// Number, within the character, of the vertex that comes from there.
    pub vertex: u32,
    /// As in [`crowd_pack::VertexRecord`].
    pub joints: [u32; 2],
    /// As in [`crowd_pack::VertexRecord`].
    pub weights: [u32; 2],
}

/// What its vertices need to know of a drawn instance, 64 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct DrawnInstance {
    /// Feet, metres.
    pub position: [f32; 3],
    /// Size factor.
    pub scale: f32,
    /// Sine and cosine of its yaw.
    pub turn: [f32; 2],
    /// Of its [`MorphRecord`].
    pub fraction: f32,
    /// Share of the later of its two frames, 0 to 1.
    pub blend: f32,
    /// Of its [`MorphRecord`].
    pub coarser_vertex_count: u32,
    /// First material of its character.
    pub material_offset: u32,
    /// First texel of the earlier frame's matrices.
    pub first_texel: u32,
    /// First texel of the later frame's matrices.
    pub second_texel: u32,
    /// First of its skinned vertices; [`crowd_pack::NONE`] where there was no room for them.
    pub vertex_base: u32,
    /// First row of its palette.
    pub palette_row: u32,
    /// Rows of its palette, three a joint; none where it is drawn as dots.
    pub row_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// A skinned vertex in its character's own space, 24 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct SkinnedVertex {
    /// Metres.
    pub x: f32,
    /// Metres.
    pub y: f32,
    /// Metres.
    pub z: f32,
    /// Normal, of any length.
    pub normal_x: f32,
    /// Normal, of any length.
    pub normal_y: f32,
    /// Normal, of any length.
    pub normal_z: f32,
}

/// Where a bucket's skinned vertices lie, 16 bytes: those of its first instance, then those of the next.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct BucketPlace {
    /// The first; [`crowd_pack::NONE`] where there is no room.
    pub vertex_base: u32,
    /// First instance in the sorted list.
    pub first: u32,
    /// Vertices of the level.
    pub vertex_count: u32,
    /// The character's first vertex among all.
    pub vertex_offset: u32,
}

/// Groups of an indirect dispatch, 12 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct DispatchArgs {
    /// In a row.
    pub x: u32,
    /// Rows.
    pub y: u32,
    /// 1.
    pub z: u32,
}

/// A character's buckets, 16 bytes: its first levels have 16-bit indices, the others 32-bit ones.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct BucketSet {
    /// Bucket of the coarsest level, if that has 16-bit indices.
    pub first_16: u32,
    /// Levels with 16-bit indices.
    pub count_16: u32,
    /// Bucket of the first level with 32-bit indices, if there is one.
    pub first_32: u32,
    /// Levels of both.
    pub level_count: u32,
}

/// How many buckets there are, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct BucketCounts {
    /// All; also the key of instances in none.
    pub bucket_count: u32,
    /// Those with 16-bit indices; they come first.
    pub count_16: u32,
    /// Those of meshes; levels of dots come after them, [`dispatch::DOT_LEVELS`] a character.
    pub mesh_count: u32,
    /// Rows of the largest palette, three a joint: each drawn instance has room for so many.
    pub palette_rows: u32,
}

/// How far an instance's level is on the way from the next coarser one, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MorphRecord {
    /// Vertices of the coarser level: those from here on move.
    pub coarser_vertex_count: u32,
    /// 0: where the coarser level has them; 1: at their own places.
    pub fraction: f32,
}

/// Instances of a bucket in the sorted list, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct BucketRange {
    /// First.
    pub first: u32,
    /// One past the last.
    pub end: u32,
}

/// Draws of each kind that draw anything, 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct DrawCounts {
    /// With 16-bit indices.
    pub count_16: u32,
    /// With 32-bit indices.
    pub count_32: u32,
    /// Of dots.
    pub dot_count: u32,
    /// Zero.
    pub reserved: u32,
}

/// One pass of `sort_instances`, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct SortPass {
    /// Lowest bit of the digit.
    pub shift: u32,
    /// Bits of the digit, at most [`dispatch::MAX_DIGIT_BITS`].
    pub bits: u32,
    /// 1 in the first pass: the values are the instances' numbers.
    pub is_first: u32,
    /// Zero.
    pub reserved: u32,
}

/// A corner of the scenery, 28 bytes; goes to the GPU as a vertex buffer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct SceneryVertex {
    /// World, metres.
    pub position: [f32; 3],
    /// Linear RGBA8, red first.
    pub color: [u8; 4],
    /// World, unit.
    pub normal: [f32; 3],
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

/// Numbers the shaders and the dispatches agree on; `shaders/shared/records.wgsl` has the same.
pub mod dispatch {
    /// Workgroups beyond 65,535 are folded into rows of this many.
    pub const FOLD_COLUMNS: u32 = 32_768;
    /// Threads of a group that works on one element each.
    pub const BLOCK_SIZE: u32 = 256;
    /// Threads of a group that works on one instance.
    pub const INSTANCE_GROUP_SIZE: u32 = 64;
    /// Threads of a sorting group, each with one instance; also the most values of a digit.
    pub const SORT_BLOCK_SIZE: u32 = 64;
    /// Heights that `fill_budget` tries in one pass.
    pub const FILL_CANDIDATES: u32 = 16;
    /// Entries of a character's error table: 32 for each doubling of the pixels that a metre takes.
    pub const ERROR_ENTRIES: u32 = 1024;
    /// Float bits of the first: 2^-16 a metre.
    pub const ERROR_FIRST_BITS: u32 = (127 - 16) << 23;
    /// Float bits of an entry.
    pub const ERROR_SHIFT: u32 = 18;
    /// Most shadow maps of the sun.
    pub const MAX_CASCADES: u32 = 4;
    /// Levels of the largest depth pyramid.
    pub const PYRAMID_LEVELS: u32 = 16;
    /// At most this part of the budget is kept for who comes into sight.
    pub const RESERVE_PART: u32 = 128;
    /// Levels of dots below a character's coarsest mesh: of one, two, four, ... dots.
    pub const DOT_LEVELS: u32 = 5;
    /// Vertices of a dot.
    pub const DOT_VERTICES: u32 = 3;
    /// Most bits of a digit of the sort.
    pub const MAX_DIGIT_BITS: u32 = 6;
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
        let plane = config.planes[5];
        assert!(Vec3::new(plane[0], plane[1], plane[2]).dot(far) + plane[3] >= 0.0);
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
