//! Dispatches of water filling: three passes of the search, then the steps' prefix sums and the levels.

use super::kernel::{Kernel, Use, blocks, stage_source};
use crate::cpu::FILL_PASSES;
use crate::dispatch::FILL_CANDIDATES;

/// Shader: `shaders/stages/fill_budget.wgsl`. Twin: [`crate::cpu::fill_budget`].
pub struct FillBudget {
    kernel: Kernel,
}

impl FillBudget {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/scan.wgsl")],
            include_str!("../../../../shaders/stages/fill_budget.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses =
            [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write, Use::Write];
        let entry_points = ["begin", "sum_candidates", "narrow", "sum_steps", "scan_steps", "choose_levels"];
        Self { kernel: Kernel::new(device, "fill_budget", Self::source(), &entry_points, &uses) }
    }

    /// Words of `block_counts` for that many instances.
    pub fn block_count_words(instance_count: u32) -> u64 {
        u64::from(blocks(instance_count)) * u64::from(FILL_CANDIDATES)
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        lods: &wgpu::Buffer,
        culled: &wgpu::Buffer,
        block_counts: &wgpu::Buffer,
        fill: &wgpu::Buffer,
        sums: &wgpu::Buffer,
        choices: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, instances, characters, lods, culled, block_counts, fill, sums, choices])
    }

    /// Records the dispatches for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        let groups = blocks(instance_count);
        self.kernel.dispatch(pass, 0, bound, 1);
        for _ in 0..FILL_PASSES {
            self.kernel.dispatch(pass, 1, bound, groups);
            self.kernel.dispatch(pass, 2, bound, 1);
        }
        self.record_steps(pass, bound, instance_count);
    }

    /// Records the last part alone: between the two heights that the state has, the first instances take the step.
    pub fn record_steps(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        let groups = blocks(instance_count);
        self.kernel.dispatch(pass, 3, bound, groups);
        self.kernel.dispatch(pass, 4, bound, 1);
        self.kernel.dispatch(pass, 5, bound, groups);
    }
}
