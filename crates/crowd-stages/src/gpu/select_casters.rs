//! Dispatch of the casters' selection: one thread an instance.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/select_casters.wgsl`. Twin: [`crate::cpu::select_casters`].
pub struct SelectCasters {
    kernel: Kernel,
}

impl SelectCasters {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[
                include_str!("../../../../shaders/shared/place.wgsl"),
                include_str!("../../../../shaders/shared/light.wgsl"),
                include_str!("../../../../shaders/shared/levels.wgsl"),
            ],
            include_str!("../../../../shaders/stages/select_casters.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let [u, r, w] = [Use::Uniform, Use::Read, Use::Write];
        let uses = [u, u, u, r, r, r, r, w, r, r];
        Self { kernel: Kernel::new(device, "select_casters", Self::source(), &["select_casters"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        shadow: &wgpu::Buffer,
        step: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        clips: &wgpu::Buffer,
        error_lods: &wgpu::Buffer,
        choices: &wgpu::Buffer,
        casters: &wgpu::Buffer,
        bucket_sets: &wgpu::Buffer,
        buckets: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let of_crowd = [instances, clips, error_lods, choices, casters, bucket_sets, buckets];
        self.kernel.bind(device, &[&[config, shadow, step][..], &of_crowd].concat())
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}
