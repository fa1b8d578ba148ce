//! Dispatch of what drawn instances tell their vertices: one thread an instance.

use super::kernel::{Gate, Groups, Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/gather_drawn.wgsl`. Twin: [`crate::cpu::gather_drawn`].
pub struct GatherDrawn {
    kernel: Kernel,
}

impl GatherDrawn {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/place.wgsl")],
            include_str!("../../../../shaders/stages/gather_drawn.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [
            Use::Uniform,
            Use::Uniform,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Read,
            Use::Write,
        ];
        Self { kernel: Kernel::new(device, "gather_drawn", Self::source(), &["gather_drawn", "scatter_drawn"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order. For [`Self::record_scattered`] keys and places of the instances are in the place of
    /// the sorted keys and values.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        clips: &wgpu::Buffer,
        morphs: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        sorted_values: &wgpu::Buffer,
        places: &wgpu::Buffer,
        drawn: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(
            device,
            &[config, bucket_counts, instances, characters, clips, morphs, sorted_keys, sorted_values, places, drawn],
        )
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }

    /// The same in the order of the instances, which writes what that writes.
    pub fn record_scattered(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.record_gated(pass, bound, instance_count, None);
    }

    pub(crate) fn record_gated(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        instance_count: u32,
        gate: Gate<'_>,
    ) {
        self.kernel.dispatch_gated(pass, 1, bound, (Groups::Blocks, blocks(instance_count)), gate);
    }
}
