//! Dispatches of the summing stage: a tree a block, then one group over the blocks.

use super::kernel::{Gate, Groups, Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/sum_weights.wgsl`. Twin: [`crate::cpu::sum_weights`].
pub struct SumWeights {
    kernel: Kernel,
}

impl SumWeights {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/sum_weights.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Write, Use::Write];
        Self { kernel: Kernel::new(device, "sum_weights", Self::source(), &["sum_blocks", "sum_all"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        culled: &wgpu::Buffer,
        block_sums: &wgpu::Buffer,
        sums: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, characters, culled, block_sums, sums])
    }

    /// Records the dispatches for that many instances.
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
        self.kernel.dispatch_gated(pass, 1, bound, (Groups::One, 1), gate);
    }
}
