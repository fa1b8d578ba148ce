//! Dispatch of the keys: one thread an instance.

use super::kernel::{Gate, Groups, Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/key_instances.wgsl`. Twins: [`crate::cpu::key_instances`], [`crate::cpu::key_full_detail`].
pub struct KeyInstances {
    kernel: Kernel,
}

impl KeyInstances {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/levels.wgsl")],
            include_str!("../../../../shaders/stages/key_instances.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [
            Use::Uniform,
            Use::Uniform,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Write,
            Use::Write,
        ];
        let entry_points = ["key_levels", "key_full_detail"];
        Self { kernel: Kernel::new(device, "key_instances", Self::source(), &entry_points, &uses) }
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
        choices: &wgpu::Buffer,
        fill: &wgpu::Buffer,
        keys: &wgpu::Buffer,
        morphs: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(
            device,
            &[config, bucket_counts, instances, bucket_sets, buckets, culled, choices, fill, keys, morphs],
        )
    }

    /// Records the dispatch for that many instances: the buckets of the levels chosen.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.record_gated(pass, bound, instance_count, None);
    }

    pub(crate) fn record_gated(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        instance_count: u32,
        gate: Gate<'_>,
    ) {
        self.kernel.dispatch_gated(pass, 0, bound, (Groups::Blocks, blocks(instance_count)), gate);
    }

    /// Records the dispatch for that many instances: the buckets of full detail.
    pub fn record_full_detail(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 1, bound, blocks(instance_count));
    }
}
