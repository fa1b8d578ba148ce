//! Dispatches of the prefix sums: sums of blocks, a scan over the blocks, a scan within each.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/scan_counts.wgsl`. Twin: [`crate::cpu::scan_counts`].
pub struct ScanCounts {
    kernel: Kernel,
}

impl ScanCounts {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/scan_counts.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Write, Use::Write, Use::Write];
        Self {
            kernel: Kernel::new(
                device,
                "scan_counts",
                Self::source(),
                &["sum_blocks", "scan_blocks", "write_bases"],
                &uses,
            ),
        }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        choices: &wgpu::Buffer,
        block_totals: &wgpu::Buffer,
        bases: &wgpu::Buffer,
        totals: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, choices, block_totals, bases, totals])
    }

    /// Records the dispatches for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
        self.kernel.dispatch(pass, 1, bound, 1);
        self.kernel.dispatch(pass, 2, bound, blocks(instance_count));
    }
}
