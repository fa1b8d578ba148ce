//! Dispatches of lent vertices: one thread an entry of a sorted list.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/lend_vertices.wgsl`. Twins: [`crate::cpu::lend_vertices`], [`crate::cpu::borrow_vertices`].
pub struct LendVertices {
    kernel: Kernel,
}

impl LendVertices {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/lend_vertices.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let [u, r, w] = [Use::Uniform, Use::Read, Use::Write];
        let entry_points = ["lend_vertices", "borrow_vertices"];
        Self { kernel: Kernel::new(device, "lend_vertices", Self::source(), &entry_points, &[u, u, r, r, w, w]) }
    }

    /// Binds the buffers of the shader's bindings, in their order: the lists of who lends or of who borrows.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        sorted_values: &wgpu::Buffer,
        drawn: &wgpu::Buffer,
        lent: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, bucket_counts, sorted_keys, sorted_values, drawn, lent])
    }

    /// Records who lends what, for that many instances.
    pub fn record_lend(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }

    /// Records who borrows what, for that many instances.
    pub fn record_borrow(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 1, bound, blocks(instance_count));
    }
}
