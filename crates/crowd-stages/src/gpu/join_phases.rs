//! Dispatches between the phases of occlusion culling and after them: one thread each.

use super::kernel::{Gate, Groups, Kernel, Use, stage_source};

/// Shader: `shaders/stages/join_phases.wgsl`. Twins: [`crate::cpu::begin_second`], [`crate::cpu::join_phases`].
pub struct JoinPhases {
    kernel: Kernel,
}

impl JoinPhases {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/join_phases.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "join_phases", Self::source(), &["begin_second", "join"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        sums: &wgpu::Buffer,
        second_sums: &wgpu::Buffer,
        fill: &wgpu::Buffer,
        tally: &wgpu::Buffer,
        second_fill: &wgpu::Buffer,
        first_totals: &wgpu::Buffer,
        totals: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, sums, second_sums, fill, tally, second_fill, first_totals, totals])
    }

    /// Records the water of the second phase; `first_totals` has what the first came to.
    pub fn record_begin(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup) {
        self.record_gated_begin(pass, bound, None);
    }

    pub(crate) fn record_gated_begin(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, gate: Gate<'_>) {
        self.kernel.dispatch_gated(pass, 0, bound, (Groups::One, 1), gate);
    }

    /// Records the sum of both; `totals` has what the second came to.
    pub fn record_join(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup) {
        self.kernel.dispatch(pass, 1, bound, 1);
    }
}
