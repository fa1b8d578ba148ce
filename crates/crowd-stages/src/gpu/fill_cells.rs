//! Dispatch of the cells' lists: one thread a boid or a cell.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/fill_cells.wgsl`. Twin: [`crate::cpu::fill_cells`].
pub struct FillCells {
    kernel: Kernel,
}

impl FillCells {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/fill_cells.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write];
        Self { kernel: Kernel::new(device, "fill_cells", Self::source(), &["fill_cells"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        flock: &wgpu::Buffer,
        boids: &wgpu::Buffer,
        sorted_cells: &wgpu::Buffer,
        sorted_numbers: &wgpu::Buffer,
        starts: &wgpu::Buffer,
        sorted_boids: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[flock, boids, sorted_cells, sorted_numbers, starts, sorted_boids])
    }

    /// Records the dispatch for that many boids and cells.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, boid_count: u32, cell_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(boid_count.max(cell_count + 1)));
    }
}
