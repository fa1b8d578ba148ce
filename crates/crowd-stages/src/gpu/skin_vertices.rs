//! Dispatch of skinning: one thread a vertex, as many groups as were placed.

use super::kernel::{Kernel, Use, stage_source};

/// Shader: `shaders/stages/skin_vertices.wgsl`. Twin: [`crate::cpu::skin_vertices`].
pub struct SkinVertices {
    kernel: Kernel,
}

impl SkinVertices {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/skin.wgsl")],
            include_str!("../../../../shaders/stages/skin_vertices.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "skin_vertices", Self::source(), &["skin_vertices"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        bucket_counts: &wgpu::Buffer,
        places: &wgpu::Buffer,
        drawn: &wgpu::Buffer,
        vertices: &wgpu::Buffer,
        origins: &wgpu::Buffer,
        palettes: &wgpu::Buffer,
        skinned: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[bucket_counts, places, drawn, vertices, origins, palettes, skinned])
    }

    /// Records the dispatch of the groups that `place_buckets` wrote.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, dispatch: &wgpu::Buffer) {
        self.kernel.dispatch_indirect(pass, 0, bound, dispatch);
    }
}
