//! Dispatch of leaders: one thread an entry of the sorted list.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/find_leaders.wgsl`. Twin: [`crate::cpu::find_leaders`].
pub struct FindLeaders {
    kernel: Kernel,
}

impl FindLeaders {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/find_leaders.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write];
        Self { kernel: Kernel::new(device, "find_leaders", Self::source(), &["find_leaders"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        pose_counts: &wgpu::Buffer,
        sorted_pose_keys: &wgpu::Buffer,
        sorted_by_pose: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        sorted_values: &wgpu::Buffer,
        leads: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let sorted = [sorted_pose_keys, sorted_by_pose, sorted_keys, sorted_values];
        self.kernel.bind(device, &[config, pose_counts, sorted[0], sorted[1], sorted[2], sorted[3], leads])
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}
