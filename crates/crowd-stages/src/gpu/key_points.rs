//! Dispatch of keys for points: one thread an instance.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/key_points.wgsl`. Twin: [`crate::cpu::key_points`].
pub struct KeyPoints {
    kernel: Kernel,
}

impl KeyPoints {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/key_points.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "key_points", Self::source(), &["key_points"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        bucket_sets: &wgpu::Buffer,
        buckets: &wgpu::Buffer,
        culled: &wgpu::Buffer,
        keys: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, bucket_counts, instances, bucket_sets, buckets, culled, keys])
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}
