//! Dispatches of the sort in one pass: counts, prefix sums, moves.

use super::kernel::{Gate, Groups, Kernel, Use, stage_source};
use crate::dispatch::{AT_ONCE_GROUP_SIZE, AT_ONCE_KEYS, AT_ONCE_RUNS, AT_ONCE_SHORTEST};

/// Shader: `shaders/stages/sort_at_once.wgsl`. Twin: [`crate::cpu::sort_at_once`].
pub struct SortAtOnce {
    kernel: Kernel,
}

impl SortAtOnce {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(
            &[include_str!("../../../../shaders/shared/scan.wgsl")],
            include_str!("../../../../shaders/stages/sort_at_once.wgsl"),
        )
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Write, Use::Write, Use::Write, Use::Write, Use::Write];
        let entry_points = ["count_keys", "scan_keys", "move_at_once"];
        Self { kernel: Kernel::new(device, "sort_at_once", Self::source(), &entry_points, &uses) }
    }

    /// Whether it is for such a device and so many buckets. Cards have a group for every few thousand instances, but not for every few hundred
    /// threads, and there `sort_instances` is made for them.
    pub(crate) fn suits(is_software: bool, bucket_count: u32) -> bool {
        is_software && bucket_count < AT_ONCE_KEYS
    }

    /// Words of `key_counts` for that many instances and buckets.
    pub fn count_words(instance_count: u32, bucket_count: u32) -> u64 {
        u64::from(runs(instance_count)) * (u64::from(bucket_count) + 1)
    }

    /// Binds the buffers of the shader's bindings, in their order. `bucket_counts`: of fewer than `AT_ONCE_KEYS` buckets.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        bucket_counts: &wgpu::Buffer,
        keys: &wgpu::Buffer,
        key_counts: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        sorted_values: &wgpu::Buffer,
        entries: &wgpu::Buffer,
        ranges: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        let buffers = [config, bucket_counts, keys, key_counts, sorted_keys, sorted_values, entries, ranges];
        self.kernel.bind(device, &buffers)
    }

    /// Records the dispatches for that many instances, or for fewer: a frame's own count may be less than what it is recorded for.
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
        let groups = runs(instance_count).div_ceil(AT_ONCE_GROUP_SIZE);
        self.kernel.dispatch_gated(pass, 0, bound, (Groups::Runs, groups), gate);
        self.kernel.dispatch_gated(pass, 1, bound, (Groups::One, 1), gate);
        self.kernel.dispatch_gated(pass, 2, bound, (Groups::Runs, groups), gate);
    }
}

/// Runs of that many instances; fewer instances never have more.
fn runs(instance_count: u32) -> u32 {
    instance_count.div_ceil(instance_count.div_ceil(AT_ONCE_RUNS).max(AT_ONCE_SHORTEST))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fewer_instances_never_have_more_runs() {
        for count in 0..300_000 {
            assert!(runs(count) <= runs(count + 1) && runs(count) <= AT_ONCE_RUNS, "{count}");
        }
        assert_eq!([0, 1, AT_ONCE_SHORTEST, AT_ONCE_SHORTEST + 1].map(runs), [0, 1, 1, 2]);
        assert_eq!([1_000_000, u32::MAX].map(runs), [AT_ONCE_RUNS; 2]);
    }
}
