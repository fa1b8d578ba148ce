//! Dispatch of a step: one thread a boid.

use super::kernel::{Kernel, Use, stage_source};
use crate::dispatch::INSTANCE_GROUP_SIZE;

/// Shader: `shaders/stages/steer_boids.wgsl`. Twin: [`crate::cpu::steer_boids`].
pub struct SteerBoids {
    kernel: Kernel,
}

impl SteerBoids {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        let shared = include_str!("../../../../shaders/shared/flock.wgsl");
        stage_source(&[shared], include_str!("../../../../shaders/stages/steer_boids.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "steer_boids", Self::source(), &["steer_boids"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        flock: &wgpu::Buffer,
        sorted_numbers: &wgpu::Buffer,
        sorted_boids: &wgpu::Buffer,
        starts: &wgpu::Buffer,
        boids: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[flock, sorted_numbers, sorted_boids, starts, boids])
    }

    /// Records the dispatch for that many boids.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, boid_count: u32) {
        self.kernel.dispatch(pass, 0, bound, boid_count.div_ceil(INSTANCE_GROUP_SIZE));
    }
}
