//! Dispatches of the recall: one thread an instance, then the reserve.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/recall_seen.wgsl`. Twin: [`crate::cpu::recall_seen`].
pub struct RecallSeen {
    kernel: Kernel,
}

impl RecallSeen {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/recall_seen.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses =
            [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write, Use::Write, Use::Write];
        Self { kernel: Kernel::new(device, "recall_seen", Self::source(), &["recall", "reserve"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        seen: &wgpu::Buffer,
        culled: &wgpu::Buffer,
        block_tallies: &wgpu::Buffer,
        tally: &wgpu::Buffer,
        first_config: &wgpu::Buffer,
        gate: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel
            .bind(device, &[config, instances, characters, seen, culled, block_tallies, tally, first_config, gate])
    }

    /// Records the dispatches for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
        self.kernel.dispatch(pass, 1, bound, 1);
    }
}
