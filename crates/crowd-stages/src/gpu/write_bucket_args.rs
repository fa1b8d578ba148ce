//! Dispatches of the buckets' arguments: clear, find where buckets begin and end, write.

use super::kernel::{Gate, Groups, Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/write_bucket_args.wgsl`. Twin: [`crate::cpu::write_bucket_args`].
pub struct WriteBucketArgs {
    kernel: Kernel,
}

impl WriteBucketArgs {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/scan.wgsl")],
            include_str!("../../../../shaders/stages/write_bucket_args.wgsl"),
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
            Use::Write,
            Use::Write,
            Use::Write,
            Use::Write,
        ];
        let entry_points = ["clear_ranges", "find_ranges", "write_args"];
        Self { kernel: Kernel::new(device, "write_bucket_args", Self::source(), &entry_points, &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        sums: &wgpu::Buffer,
        buckets: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        ranges: &wgpu::Buffer,
        draw_args: &wgpu::Buffer,
        draw_counts: &wgpu::Buffer,
        totals: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel
            .bind(device, &[config, bucket_counts, sums, buckets, sorted_keys, ranges, draw_args, draw_counts, totals])
    }

    /// Records the dispatches for that many instances and buckets.
    pub fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        instance_count: u32,
        bucket_count: u32,
    ) {
        self.kernel.dispatch(pass, 0, bound, blocks(bucket_count));
        self.kernel.dispatch(pass, 1, bound, blocks(instance_count));
        self.record_args(pass, bound);
    }

    /// The same where it is known which instances are in which bucket.
    pub fn record_args(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup) {
        self.record_gated_args(pass, bound, None);
    }

    pub(crate) fn record_gated_args(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, gate: Gate<'_>) {
        self.kernel.dispatch_gated(pass, 2, bound, (Groups::One, 1), gate);
    }
}
