//! Dispatch of the flock's instances: one thread a boid.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/place_boids.wgsl`. Twin: [`crate::cpu::place_boids`].
pub struct PlaceBoids {
    kernel: Kernel,
}

impl PlaceBoids {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        let shared = include_str!("../../../../shaders/shared/place.wgsl");
        stage_source(&[shared], include_str!("../../../../shaders/stages/place_boids.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "place_boids", Self::source(), &["place_boids"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        flock: &wgpu::Buffer,
        boids: &wgpu::Buffer,
        traits: &wgpu::Buffer,
        movers: &wgpu::Buffer,
        instances: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[flock, boids, traits, movers, instances])
    }

    /// Records the dispatch for that many boids.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, boid_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(boid_count));
    }
}
