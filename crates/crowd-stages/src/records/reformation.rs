//! Places in the frame's vertex list and index buffer.

use bytemuck::{Pod, Zeroable};

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
    /// Of `reform_triangles`: the first triangle of the part of the index buffer that it is bound to.
    pub window_first: u32,
    /// How many that part has; 0: it is bound to all.
    pub window_count: u32,
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
