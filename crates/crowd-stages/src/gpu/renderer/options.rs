//! What is fixed for a renderer's life.

use crate::{DrawOptions, DrawnInstance, InstanceRecord, Technique};
use std::mem::size_of;

/// Sizes and formats fixed for a renderer's life.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RendererOptions {
    /// Instances it can hold.
    pub max_instances: u32,
    /// Vertices a frame it can hold: the largest N.
    pub max_vertices: u32,
    /// Triangles a frame it can hold.
    pub max_triangles: u32,
    /// Colour target; sRGB formats are expected.
    pub color_format: wgpu::TextureFormat,
    /// 1 or 4 samples a pixel.
    pub sample_count: u32,
    /// Depth target: 24 bits or more, with a stencil or without. Only for [`super::CrowdRenderer::encode_into`] anything else than `Depth32Float` pays.
    pub depth_format: wgpu::TextureFormat,
    /// Cameras have depth 1 near and 0 far, instead of 0 near and 1 far.
    pub reverse_z: bool,
}

impl Default for RendererOptions {
    /// Ten thousand instances and two million vertices a frame, one sample a pixel.
    fn default() -> Self {
        Self {
            max_instances: 10_000,
            max_vertices: 2_000_000,
            max_triangles: 4_000_000,
            color_format: wgpu::TextureFormat::Rgba8UnormSrgb,
            sample_count: 1,
            depth_format: wgpu::TextureFormat::Depth32Float,
            reverse_z: false,
        }
    }
}

impl RendererOptions {
    /// The same, with vertices and triangles lowered to what a device of these limits can hold: 33.5 million vertices where a binding
    /// may have 128 MiB, and 178 million triangles where a buffer may have 2 GiB.
    pub fn clamped_to(self, limits: &wgpu::Limits) -> Self {
        let words = |bytes: u64| u32::try_from(bytes / 4).unwrap_or(u32::MAX);
        let bindable = words(limits.max_storage_buffer_binding_size.min(limits.max_buffer_size));
        // Triangles are written in parts.
        let indices = words(limits.max_buffer_size);
        Self {
            max_vertices: self.max_vertices.min(bindable),
            max_triangles: self.max_triangles.min(indices / 3),
            ..self
        }
    }
}

/// The most instances that a device of these limits draws so: where a binding may have 128 MiB, 2,796,202, and 1,677,721 where they are
/// gathered for the draw.
pub fn most_instances(limits: &wgpu::Limits, draw: &DrawOptions) -> u32 {
    use Technique::{PseudoInstancing, Reform, StaticFloor};
    let gathers = draw.shadows > 0 || !matches!(draw.technique, PseudoInstancing | Reform | StaticFloor);
    let record = if gathers { size_of::<DrawnInstance>() } else { size_of::<InstanceRecord>() };
    let binding = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
    u32::try_from(binding / record as u64).unwrap_or(u32::MAX)
}
