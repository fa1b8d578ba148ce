//! Dispatches of the sort: for each digit counts, prefix sums, moves.

use super::kernel::{Kernel, Use, stage_source};
use crate::SortPass;
use crate::dispatch::{MAX_DIGIT_BITS, SORT_BLOCK_SIZE, SORT_RUN};

/// Shader: `shaders/stages/sort_instances.wgsl`. Twin: [`crate::cpu::sort_instances`].
pub struct SortInstances {
    kernel: Kernel,
}

impl SortInstances {
    /// The stage's WGSL as it is compiled.
    pub fn source() -> String {
        stage_source(&[], include_str!("../../../../shaders/stages/sort_instances.wgsl"))
    }

    /// Compiles the stage.
    pub fn new(device: &wgpu::Device) -> Self {
        let uses = [Use::Uniform, Use::Uniform, Use::Read, Use::Read, Use::Write, Use::Write, Use::Write];
        let entry_points = ["count_digits", "scan_digits", "scan_values", "move_entries"];
        Self { kernel: Kernel::new(device, "sort_instances", Self::source(), &entry_points, &uses) }
    }

    /// The passes that sort keys of at most `largest_key`: as few digits as can be, of about equal bits.
    pub fn passes(largest_key: u32) -> Vec<SortPass> {
        let bits = (u32::BITS - largest_key.leading_zeros()).max(1);
        let count = bits.div_ceil(MAX_DIGIT_BITS);
        let each = bits.div_ceil(count);
        let pass = |p: u32| SortPass {
            shift: p * each,
            bits: each.min(bits - p * each),
            is_first: u32::from(p == 0),
            reserved: 0,
        };
        (0..count).map(pass).collect()
    }

    /// Words of `digit_counts` for that many instances.
    pub fn digit_count_words(instance_count: u32) -> u64 {
        let values = 1 << MAX_DIGIT_BITS;
        u64::from(instance_count.div_ceil(SORT_BLOCK_SIZE * SORT_RUN)) * values + values
    }

    /// Binds the buffers of one pass, in the order of the shader's bindings. `values` are not read in the first pass.
    pub fn bind(
        &self,
        device: &wgpu::Device,
        config: &wgpu::Buffer,
        sort: &wgpu::Buffer,
        keys: &wgpu::Buffer,
        values: &wgpu::Buffer,
        digit_counts: &wgpu::Buffer,
        sorted_keys: &wgpu::Buffer,
        sorted_values: &wgpu::Buffer,
    ) -> wgpu::BindGroup {
        self.kernel.bind(device, &[config, sort, keys, values, digit_counts, sorted_keys, sorted_values])
    }

    /// Records the dispatches of one pass for that many instances.
    pub fn record(
        &self,
        pass: &mut wgpu::ComputePass<'_>,
        bound: &wgpu::BindGroup,
        sort: &SortPass,
        instance_count: u32,
    ) {
        let groups = instance_count.div_ceil(SORT_BLOCK_SIZE * SORT_RUN);
        self.kernel.dispatch(pass, 0, bound, groups);
        self.kernel.dispatch(pass, 1, bound, if groups == 0 { 0 } else { 1 << sort.bits });
        self.kernel.dispatch(pass, 2, bound, groups.min(1));
        self.kernel.dispatch(pass, 3, bound, groups);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_cover_the_largest_key_and_no_more() {
        for largest in [0, 1, 63, 64, 897, 4095, 4096, 262_144, u32::MAX] {
            let passes = SortInstances::passes(largest);
            let bits: u32 = passes.iter().map(|p| p.bits).sum();
            assert!(u64::from(largest) < 1 << bits && passes.iter().all(|p| p.bits <= MAX_DIGIT_BITS));
            assert!(passes.windows(2).all(|w| w[0].shift + w[0].bits == w[1].shift));
            assert_eq!(passes.iter().map(|p| p.is_first).sum::<u32>(), 1);
        }
        assert_eq!(SortInstances::passes(897).len(), 2);
    }
}
