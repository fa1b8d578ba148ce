//! What the crowd's vertex shaders are fed with: words of 16 bytes, which is what a vertex fetch is fastest at.

use crate::{DrawnInstance, OriginRecord};
use crowd_pack::VertexRecord;
use std::mem::size_of;
use wgpu::{VertexAttribute, VertexBufferLayout, VertexStepMode};

const MESH: [VertexAttribute; 3] = wgpu::vertex_attr_array![0 => Uint32x4, 1 => Uint32x4, 2 => Uint32x4];
const ORIGINS: [VertexAttribute; 3] = wgpu::vertex_attr_array![3 => Uint32x4, 4 => Uint32x4, 5 => Uint32x4];
const OWNERS: [VertexAttribute; 5] =
    wgpu::vertex_attr_array![6 => Float32x4, 7 => Float32x4, 8 => Uint32x4, 9 => Uint32x4, 10 => Uint32x4];

/// The vertices of all characters.
pub(crate) const MESH_LAYOUT: VertexBufferLayout<'static> = VertexBufferLayout {
    array_stride: size_of::<VertexRecord>() as u64,
    step_mode: VertexStepMode::Vertex,
    attributes: &MESH,
};

/// Where they come from.
pub(crate) const ORIGIN_LAYOUT: VertexBufferLayout<'static> = VertexBufferLayout {
    array_stride: size_of::<OriginRecord>() as u64,
    step_mode: VertexStepMode::Vertex,
    attributes: &ORIGINS,
};

/// Drawn instances.
pub(crate) const OWNER_LAYOUT: VertexBufferLayout<'static> = VertexBufferLayout {
    array_stride: size_of::<DrawnInstance>() as u64,
    step_mode: VertexStepMode::Instance,
    attributes: &OWNERS,
};
