//! Dispatch of palettes: one thread a joint of each instance.

use super::kernel::{Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/blend_palettes.wgsl`. Twin: [`crate::cpu::blend_palettes`].
pub struct BlendPalettes {
    kernel: Kernel,
}

impl BlendPalettes {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[
                include_str!("../../../../shaders/shared/pose.wgsl"),
                include_str!("../../../../shaders/shared/frames.wgsl"),
            ],
            include_str!("../../../../shaders/stages/blend_palettes.wgsl"),
        )
    }

    /// Compiles the stage. `joint_storages`: those that characters have, a bit for each [`crowd_pack::JointStorage::code`].
    pub fn new(device: &wgpu::Device, joint_storages: u32) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Frames, Use::Write];
        let (name, constants) = ("blend_palettes", [("JOINT_STORAGES", f64::from(joint_storages))]);
        Self { kernel: Kernel::with_constants(device, name, Self::source(), &[name], &uses, &constants) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        drawn: &wgpu::Buffer,
        animation: &wgpu::TextureView,
        palettes: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let resources = [
            config.as_entire_binding(),
            bucket_counts.as_entire_binding(),
            sorted_keys.as_entire_binding(),
            drawn.as_entire_binding(),
            wgpu::BindingResource::TextureView(animation),
            palettes.as_entire_binding(),
        ];
        self.kernel.bind_resources(device, resources)
    }

    /// Records the dispatch for that many instances with `palette_rows` rows of room each.
    pub fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        instance_count: u32,
        palette_rows: u32,
    ) {
        self.kernel.dispatch(pass, 0, bound, blocks(instance_count.saturating_mul(palette_rows / 3)));
    }
}
