//! Dispatch of the cells: one thread a boid.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/cell_boids.wgsl`. Twin: [`crate::cpu::cell_boids`].
pub struct CellBoids {
    kernel: Kernel,
}

impl CellBoids {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        let shared = include_str!("../../../../shaders/shared/flock.wgsl");
        stage_source(&[shared], include_str!("../../../../shaders/stages/cell_boids.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "cell_boids", Self::source(), &["cell_boids"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        flock: &wgpu::Buffer,
        boids: &wgpu::Buffer,
        cells: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[flock, boids, cells])
    }

    /// Records the dispatch for that many boids.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, boid_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(boid_count));
    }
}
