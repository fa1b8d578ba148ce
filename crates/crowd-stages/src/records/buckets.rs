//! Levels with index tables, and the instances drawn from them.

use bytemuck::{Pod, Zeroable};

/// A quantised level of a character: what one indirect draw draws, 24 bytes.
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
    /// Indices of the draw: three a triangle, or one a point.
    pub index_count: u32,
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

/// How many buckets there are, a uniform of 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct BucketCounts {
    /// All; also the key of instances in none.
    pub bucket_count: u32,
    /// Those with 16-bit indices; they come first.
    pub count_16: u32,
    /// Those of meshes; levels of dots come after them, [`crate::dispatch::DOT_LEVELS`] a character, or of points,
    /// [`crate::dispatch::POINT_LEVELS`] a character.
    pub mesh_count: u32,
    /// Rows of the largest palette, three a joint: each slot has room for so many.
    pub palette_rows: u32,
    /// The first impostor, one a character; all where the crowd has none.
    pub first_impostor: u32,
    /// The first of impostors that cross over from the coarsest mesh, one a character.
    pub first_fade: u32,
    /// Palettes that the device can bind at a time: who comes behind the last is skinned in the vertex shader.
    pub palette_slots: u32,
    /// Zero.
    pub reserved: u32,
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

/// How far an instance's level is on the way from the next coarser one, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MorphRecord {
    /// Vertices of the coarser level: those from here on move.
    pub coarser_vertex_count: u32,
    /// 0: where the coarser level has them; 1: at their own places.
    pub fraction: f32,
}

/// One pass of `sort_instances`, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct SortPass {
    /// Lowest bit of the digit.
    pub shift: u32,
    /// Bits of the digit, at most [`crate::dispatch::MAX_DIGIT_BITS`].
    pub bits: u32,
    /// 1 in the first pass: the values are the instances' numbers.
    pub is_first: u32,
    /// Zero.
    pub reserved: u32,
}

/// Draws of each kind that draw anything, 20 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct DrawCounts {
    /// With 16-bit indices.
    pub count_16: u32,
    /// With 32-bit indices.
    pub count_32: u32,
    /// Of dots or points.
    pub dot_count: u32,
    /// Of impostors.
    pub impostor_count: u32,
    /// Of impostors that cross over.
    pub fade_count: u32,
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
