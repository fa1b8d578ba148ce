//! Dispatches of admission: one thread an instance, then one group that counts.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/admit_instances.wgsl`. Twin: [`crate::cpu::admit_instances`].
pub struct AdmitInstances {
    kernel: Kernel,
}

impl AdmitInstances {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/admit_instances.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write];
        Self { kernel: Kernel::new(device, "admit_instances", Self::source(), &["admit", "count_refused"], &uses) }
    }

    /// Words of `block_refused` for that many instances.
    pub fn block_words(most: u32) -> u64 {
        blocks(most).max(1).into()
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        feed: &wgpu::Buffer,
        given: &wgpu::Buffer,
        given_count: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        block_refused: &wgpu::Buffer,
        state: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[feed, given, given_count, characters, instances, block_refused, state])
    }

    /// Records the dispatches for at most that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, most: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(most));
        self.kernel.dispatch(pass, 1, bound, 1);
    }
}
