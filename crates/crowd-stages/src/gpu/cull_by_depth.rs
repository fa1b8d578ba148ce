//! Dispatch of culling by depth: one thread an instance.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/cull_by_depth.wgsl`. Twin: [`crate::cpu::cull_by_depth`].
pub struct CullByDepth {
    kernel: Kernel,
}

impl CullByDepth {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/place.wgsl")],
            include_str!("../../../../shaders/stages/cull_by_depth.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "cull_by_depth", Self::source(), &["cull_by_depth"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        discrete: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        discrete_buckets: &wgpu::Buffer,
        keys: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, bucket_counts, discrete, instances, characters, discrete_buckets, keys])
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}
