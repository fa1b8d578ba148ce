//! Dispatch of keys with poses: one thread an instance.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/key_poses.wgsl`. Twin: [`crate::cpu::key_poses`].
pub struct KeyPoses {
    kernel: Kernel,
}

impl KeyPoses {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[
                include_str!("../../../../shaders/shared/place.wgsl"),
                include_str!("../../../../shaders/shared/hold.wgsl"),
            ],
            include_str!("../../../../shaders/stages/key_poses.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let [r, w] = [Use::Read, Use::Write];
        let uses = [Use::Uniform, Use::Uniform, r, r, r, r, r, w, w];
        Self { kernel: Kernel::new(device, "key_poses", Self::source(), &["key_poses"], &uses) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        pose_counts: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        clips: &wgpu::Buffer,
        clip_speeds: &wgpu::Buffer,
        first_poses: &wgpu::Buffer,
        keys: &wgpu::Buffer,
        morphs: &wgpu::Buffer,
        pose_keys: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let buffers = [config, pose_counts, instances, clips, clip_speeds, first_poses, keys, morphs, pose_keys];
        self.kernel.bind(device, &buffers)
    }

    /// Records the dispatch for that many instances.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count));
    }
}
