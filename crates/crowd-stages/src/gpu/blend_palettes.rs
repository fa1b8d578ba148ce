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
        let [u, r, w] = [Use::Uniform, Use::Read, Use::Write];
        let uses = [u, u, r, r, Use::Frames, w, r, r];
        let entry_points = ["blend_palettes", "blend_leaders"];
        let constants = [("JOINT_STORAGES", f64::from(joint_storages))];
        Self {
            kernel: Kernel::with_constants(device, "blend_palettes", Self::source(), &entry_points, &uses, &constants),
        }
    }

    /// Binds the buffers of the shader's bindings, in their order. `leaders`: of `share_poses`, and how many of `scan_counts`; `None` where
    /// poses are not shared.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        drawn: &wgpu::Buffer,
        animation: &wgpu::TextureView,
        palettes: &wgpu::Buffer,
        leaders: Option<[&wgpu::Buffer; 2]>,
    ) -> wgpu::BindGroup {
        // Something has to be bound.
        let [leaders, leader_end] = leaders.unwrap_or([drawn; 2]);
        let resources = [
            config.as_entire_binding(),
            bucket_counts.as_entire_binding(),
            sorted_keys.as_entire_binding(),
            drawn.as_entire_binding(),
            wgpu::BindingResource::TextureView(animation),
            palettes.as_entire_binding(),
            leaders.as_entire_binding(),
            leader_end.as_entire_binding(),
        ];
        self.kernel.bind_resources(device, resources)
    }

    /// Records the dispatch for that many slots with `palette_rows` rows of room each, a slot an entry.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, slots: u32, palette_rows: u32) {
        self.kernel.dispatch(pass, 0, bound, blocks(slots.saturating_mul(palette_rows / 3)));
    }

    /// The same where poses are shared, a slot a leader.
    pub fn record_leaders(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        slots: u32,
        palette_rows: u32,
    ) {
        self.kernel.dispatch(pass, 1, bound, blocks(slots.saturating_mul(palette_rows / 3)));
    }
}
