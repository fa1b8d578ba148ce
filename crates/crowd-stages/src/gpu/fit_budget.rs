//! Dispatches of the budget stage: sum what was wanted, find the share, choose the levels.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/fit_budget.wgsl`. Twin: [`crate::cpu::fit_budget`].
pub struct FitBudget {
    kernel: Kernel,
}

impl FitBudget {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/fit_budget.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write];
        Self {
            kernel: Kernel::new(
                device,
                "fit_budget",
                Self::source(),
                &["sum_wanted_blocks", "find_share", "choose_levels"],
                &uses,
            ),
        }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        lods: &wgpu::Buffer,
        wanted: &wgpu::Buffer,
        block_wanted: &wgpu::Buffer,
        sums: &wgpu::Buffer,
        choices: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, instances, characters, lods, wanted, block_wanted, sums, choices])
    }

    /// Records the dispatches for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
        self.kernel.dispatch(pass, 1, bound, 1);
        self.kernel.dispatch(pass, 2, bound, blocks(instance_count));
    }
}
