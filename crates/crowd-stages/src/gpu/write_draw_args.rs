//! Dispatch of the arguments: one thread.

use super::kernel::{Kernel, Use, stage_source};

/// Shader: `shaders/stages/write_draw_args.wgsl`. Twin: [`crate::cpu::write_draw_args`].
pub struct WriteDrawArgs {
    kernel: Kernel,
}

impl WriteDrawArgs {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/kept.wgsl")],
            include_str!("../../../../shaders/stages/write_draw_args.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write];
        Self { kernel: Kernel::new(device, "write_draw_args", Self::source(), &["write_draw_args"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        capacities: &wgpu::Buffer,
        sums: &wgpu::Buffer,
        choices: &wgpu::Buffer,
        bases: &wgpu::Buffer,
        counts: &wgpu::Buffer,
        draw_args: &wgpu::Buffer,
        totals: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, capacities, sums, choices, bases, counts, draw_args, totals])
    }

    /// Records the dispatches.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup) {
        self.kernel.dispatch(pass, 0, bound, 1);
    }
}
