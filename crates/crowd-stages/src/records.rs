//! Records of the frame: `repr(C)`, no padding surprises; the same structs stand in `shaders/shared/`.

use bytemuck::{Pod, Zeroable};

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

/// What the stages need to know of a frame, a uniform of 192 bytes.
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
    /// Zeros.
    pub reserved: [u32; 3],
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

/// What a frame came to, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct FrameTotals {
    /// Instances whose sphere meets the frustum.
    pub visible_count: u32,
    /// Vertices selected.
    pub vertex_count: u32,
    /// Triangles selected.
    pub triangle_count: u32,
    /// Vertices of the visible instances' coarsest levels: the least budget that draws all of them.
    pub min_vertex_count: u32,
    /// [`overflow`] bits.
    pub overflow: u32,
    /// Vertices needed when the vertex buffer overflowed.
    pub needed_vertices: u32,
    /// Triangles needed when the index buffer overflowed.
    pub needed_triangles: u32,
    /// Zero.
    pub reserved: u32,
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
    AreaDistance,
}

/// How the crowd is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Technique {
    /// Per-frame triangle reformation into one index buffer, one indirect draw (Peng 2011 §5, Dong 2019 §5.3).
    #[default]
    Reform,
    /// One draw per instance at full detail, no culling: the papers' baseline.
    PseudoInstancing,
}
