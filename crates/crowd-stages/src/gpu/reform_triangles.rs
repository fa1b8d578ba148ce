//! Dispatch of triangle reformation: one group an instance.

use super::kernel::{Kernel, Use, instance_groups, stage_source};

/// Shader: `shaders/stages/reform_triangles.wgsl`. Twin: [`crate::cpu::reform_triangles`].
pub struct ReformTriangles {
    kernel: Kernel,
}

impl ReformTriangles {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/kept.wgsl")],
            include_str!("../../../../shaders/stages/reform_triangles.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses =
            [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "reform_triangles", Self::source(), &["reform_triangles"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order; of the indices the part that `capacities` has as its window.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        capacities: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        triangles: &wgpu::Buffer,
        collapse_map: &wgpu::Buffer,
        choices: &wgpu::Buffer,
        bases: &wgpu::Buffer,
        indices: wgpu::BufferBinding<'_>,
    ) -> wgpu::BindGroup {
        let whole = [config, capacities, instances, characters, triangles, collapse_map, choices, bases];
        let resources = whole.into_iter().map(|buffer| buffer.as_entire_binding());
        self.kernel.bind_resources(device, resources.chain([wgpu::BindingResource::Buffer(indices)]))
    }

    /// Records the dispatches for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, instance_groups(instance_count));
    }
}
