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
            &[
                include_str!("../../../../shaders/shared/pose.wgsl"),
                include_str!("../../../../shaders/shared/skin.wgsl"),
            ],
            include_str!("../../../../shaders/stages/skin_vertices.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let [r, w] = [Use::Read, Use::Write];
        let uses = [Use::Uniform, r, r, r, r, r, w, r];
        let entry_points = ["skin_vertices", "skin_leaders"];
        Self { kernel: Kernel::new(device, "skin_vertices", Self::source(), &entry_points, &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order. `leaders`: of `share_poses`; `None` where poses are not shared.
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
        leaders: Option<&wgpu::Buffer>,
    ) -> wgpu::BindGroup {
        // Something has to be bound.
        let leaders = leaders.unwrap_or(places);
        self.kernel.bind(device, &[bucket_counts, places, drawn, vertices, origins, palettes, skinned, leaders])
    }

    /// Records the dispatch of the groups that `place_buckets` wrote.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, dispatch: &wgpu::Buffer) {
        self.kernel.dispatch_indirect(pass, 0, bound, dispatch);
    }

    /// The same where poses are shared: vertices of leaders.
    pub fn record_leaders(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, dispatch: &wgpu::Buffer) {
        self.kernel.dispatch_indirect(pass, 1, bound, dispatch);
    }
}
