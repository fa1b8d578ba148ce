//! Dispatch of poses that are held for a while: one thread an instance.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/hold_poses.wgsl`. Twin: [`crate::cpu::hold_poses`].
pub struct HoldPoses {
    kernel: Kernel,
}

impl HoldPoses {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[
                include_str!("../../../../shaders/shared/place.wgsl"),
                include_str!("../../../../shaders/shared/hold.wgsl"),
            ],
            include_str!("../../../../shaders/stages/hold_poses.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Read, Use::Read, Use::Write];
        Self { kernel: Kernel::new(device, "hold_poses", Self::source(), &["hold_poses"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        clips: &wgpu::Buffer,
        clip_speeds: &wgpu::Buffer,
        instances: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, clips, clip_speeds, instances])
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}
