//! Dispatch of the keys: one thread an instance.

use super::kernel::{Gate, Groups, Kernel, Use, blocks, stage_source};

/// Shader: `shaders/stages/key_instances.wgsl`. Twins: [`crate::cpu::key_instances`], [`crate::cpu::key_full_detail`].
pub struct KeyInstances {
    kernel: Kernel,
    /// [`Self::with_dots`] alone.
    dots_first: Option<Kernel>,
}

/// Instances of a group that looks at dots first: the shader's constants.
const KEY_GROUP_INSTANCES: u32 = 64 * 16;

impl KeyInstances {
    const USES: [Use; 10] = [
        Use::Uniform,
        Use::Uniform,
        Use::Read,
        Use::Read,
        Use::Read,
        Use::Read,
        Use::Read,
        Use::Read,
        Use::Write,
        Use::Write,
    ];

    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/levels.wgsl")],
            include_str!("../../../../shaders/stages/key_instances.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let entry_points = ["key_levels", "key_full_detail"];
        let kernel = Kernel::new(device, "key_instances", Self::source(), &entry_points, &Self::USES);
        Self { kernel, dots_first: None }
    }

    /// The same that looks at those who are dots first, for adapters that are processors. `reach`: of [`crate::dot_reach`].
    pub fn with_dots(device: &wgpu::Device, reach: u32) -> Self {
        let constants = [("DOT_REACH", f64::from(reach))];
        let entry_points = ["key_dots_first"];
        let kernel =
            || Kernel::with_constants(device, "key_instances", Self::source(), &entry_points, &Self::USES, &constants);
        Self { dots_first: (reach > 0).then(kernel), ..Self::new(device) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        instances: &wgpu::Buffer,
        bucket_sets: &wgpu::Buffer,
        buckets: &wgpu::Buffer,
        culled: &wgpu::Buffer,
        choices: &wgpu::Buffer,
        fill: &wgpu::Buffer,
        keys: &wgpu::Buffer,
        morphs: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(
            device,
            &[config, bucket_counts, instances, bucket_sets, buckets, culled, choices, fill, keys, morphs],
        )
    }

    /// Records the dispatch for that many instances: the buckets of the levels chosen.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.record_gated(pass, bound, instance_count, None);
    }

    pub(crate) fn record_gated(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        instance_count: u32,
        gate: Gate<'_>,
    ) {
        // What a gate lets through is counted in blocks, and few come.
        match self.dots_first.as_ref().filter(|_| gate.is_none()) {
            Some(kernel) => kernel.dispatch(pass, 0, bound, instance_count.div_ceil(KEY_GROUP_INSTANCES)),
            None => self.kernel.dispatch_gated(pass, 0, bound, (Groups::Blocks, blocks(instance_count)), gate),
        }
    }

    /// Records the dispatch for that many instances: the buckets of full detail.
    pub fn record_full_detail(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup, instance_count: u32) {
        self.kernel.dispatch(pass, 1, bound, blocks(instance_count));
    }
}
