//! What vertices are made of.

use bytemuck::{Pod, Zeroable};

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

/// What its vertices need to know of a drawn instance, 80 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct DrawnInstance {
    /// Feet, metres.
    pub position: [f32; 3],
    /// Size factor.
    pub scale: f32,
    /// Sine and cosine of its yaw.
    pub turn: [f32; 2],
    /// Of its [`crate::MorphRecord`].
    pub fraction: f32,
    /// Share of the later of its two frames, 0 to 1.
    pub blend: f32,
    /// Of its [`crate::MorphRecord`].
    pub coarser_vertex_count: u32,
    /// First material of its character.
    pub material_offset: u32,
    /// First texel of the earlier frame's matrices.
    pub first_texel: u32,
    /// First texel of the later frame's matrices.
    pub second_texel: u32,
    /// First of its skinned vertices; [`crowd_pack::NONE`] where there was no room for them. Of impostors the clip that they show.
    pub vertex_base: u32,
    /// First row of its palette; [`crowd_pack::NONE`] where there was no room for it. Of impostors the instance's number.
    pub palette_row: u32,
    /// Rows of its palette, three a joint; none where it is drawn as dots.
    pub row_count: u32,
    /// How its character's joints are stored.
    pub storage: u32,
    /// First texel of the earlier frame's matrices in the clip it leaves; of its own where it leaves none.
    pub leaving_first_texel: u32,
    /// The same of the later frame.
    pub leaving_second_texel: u32,
    /// Share of the later of these two.
    pub leaving_blend: f32,
    /// Share of the clip it leaves; 0 where it leaves none.
    pub leaving_share: f32,
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

/// A point of a character's surface, 48 bytes, in the words of [`crowd_pack::VertexRecord`]; goes to the GPU as a vertex buffer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct PointRecord {
    /// Bind-space position, metres.
    pub position: [f32; 3],
    /// As in [`crowd_pack::VertexRecord`].
    pub normal_oct: u32,
    /// Square roots of the linear base colour; the last is 0 where light does not change it.
    pub color: [u8; 4],
    /// 1 where the back is seen, too.
    pub is_double_sided: u32,
    /// Zero.
    pub reserved: [u32; 2],
    /// As in [`crowd_pack::VertexRecord`].
    pub joints: [u32; 2],
    /// As in [`crowd_pack::VertexRecord`].
    pub weights: [u32; 2],
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
