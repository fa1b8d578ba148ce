//! Dispatch of the vertex list: one group an instance.

use super::kernel::{Kernel, Use, instance_groups, stage_source};

/// Shader: `shaders/stages/place_vertices.wgsl`. Twin: [`crate::cpu::place_vertices`].
pub struct PlaceVertices {
    kernel: Kernel,
}

impl PlaceVertices {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/kept.wgsl")],
            include_str!("../../../../shaders/stages/place_vertices.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "place_vertices", Self::source(), &["place_vertices"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        capacities: &wgpu::Buffer,
        choices: &wgpu::Buffer,
        bases: &wgpu::Buffer,
        slot_instances: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, capacities, choices, bases, slot_instances])
    }

    /// Records the dispatches for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, instance_groups(instance_count));
    }
}
