//! Dispatch of the occlusion test: one thread an instance.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/test_occlusion.wgsl`. Twin: [`crate::cpu::test_occlusion`].
pub struct TestOcclusion {
    kernel: Kernel,
}

impl TestOcclusion {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/place.wgsl")],
            include_str!("../../../../shaders/stages/test_occlusion.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Read, Use::Read, Use::Write, Use::Write];
        Self { kernel: Kernel::new(device, "test_occlusion", Self::source(), &["test_occlusion"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        pyramid: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        characters: &wgpu::Buffer,
        clips: &wgpu::Buffer,
        farthest: &wgpu::Buffer,
        culled: &wgpu::Buffer,
        seen: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, pyramid, instances, characters, clips, farthest, culled, seen])
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}
