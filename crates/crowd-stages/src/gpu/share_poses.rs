//! Dispatches of shared poses: one thread a bucket, one thread an entry of the sorted list.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/share_poses.wgsl`. Twins: [`crate::cpu::range_leaders`], [`crate::cpu::follow_leaders`].
pub struct SharePoses {
    kernel: Kernel,
}

impl SharePoses {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/place.wgsl")],
            include_str!("../../../../shaders/stages/share_poses.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let [u, r, w] = [Use::Uniform, Use::Read, Use::Write];
        let uses = [u, u, u, r, r, r, r, w, w, w];
        let entry_points = ["range_leaders", "follow_leaders"];
        Self { kernel: Kernel::new(device, "share_poses", Self::source(), &entry_points, &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        leader_end: &wgpu::Buffer,
        ranges: &wgpu::Buffer,
        leaders_before: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        places: &wgpu::Buffer,
        leader_ranges: &wgpu::Buffer,
        drawn: &wgpu::Buffer,
        leaders: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let lists = [leader_ranges, drawn, leaders];
        let read = [ranges, leaders_before, sorted_keys, places];
        let buffers: Vec<&wgpu::Buffer> =
            [config, bucket_counts, leader_end].into_iter().chain(read).chain(lists).collect();
        self.kernel.bind(device, &buffers)
    }

    /// Records the leaders of that many buckets.
    pub fn record_ranges(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, bucket_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(bucket_count));
    }

    /// Records who follows whom, for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 1, bound, blocks(instance_count));
    }
}
