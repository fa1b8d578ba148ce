//! Dispatch of the places of skinned vertices: one group.

use super::kernel::{Kernel, Use, stage_source};

/// Shader: `shaders/stages/place_buckets.wgsl`. Twin: [`crate::cpu::place_buckets`].
pub struct PlaceBuckets {
    kernel: Kernel,
}

impl PlaceBuckets {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/scan.wgsl")],
            include_str!("../../../../shaders/stages/place_buckets.wgsl"),
        )
    }

    /// Compiles the stage. `draws_the_rest`: who has no place is drawn all the same, and is no overflow.
    pub fn new(device: &wgpu::Device, draws_the_rest: bool) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write];
        let (name, constants) = ("place_buckets", [("DRAWS_THE_REST", draws_the_rest.into())]);
        Self { kernel: Kernel::with_constants(device, name, Self::source(), &[name], &uses, &constants) }
    }

    /// Binds the buffers of the shader's bindings, in their order.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        bucket_counts: &wgpu::Buffer,
        capacities: &wgpu::Buffer,
        buckets: &wgpu::Buffer,
        ranges: &wgpu::Buffer,
        places: &wgpu::Buffer,
        dispatch: &wgpu::Buffer,
        totals: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[bucket_counts, capacities, buckets, ranges, places, dispatch, totals])
    }

    /// Records the dispatch.
    pub fn record(&self, pass: &mut wgpu::ComputePass<'_>, bound: &wgpu::BindGroup) {
        self.kernel.dispatch(pass, 0, bound, 1);
    }
}
