//! `sort_instances` on the GPU against its twin: equal.

use crate::cases::{SIZES, first_difference};
use crowd_stages::{FrameConfig, cpu, gpu::SortInstances};
use crowd_tests::{gpu, synthetic};

fn on_gpu(keys: &[u32], largest_key: u32) -> (Vec<u32>, Vec<u32>) {
    let (device, _) = gpu::device();
    let stage = SortInstances::new(device);
    let n = keys.len();
    let config = gpu::uniform(&FrameConfig { instance_count: n as u32, ..Default::default() });
    let digit_counts = gpu::output::<u32>(SortInstances::digit_count_words(n as u32) as usize);
    let mut from = (gpu::storage(keys), gpu::output::<u32>(n));
    for sort in SortInstances::passes(largest_key) {
        let into = (gpu::output::<u32>(n), gpu::output::<u32>(n));
        let uniform = gpu::uniform(&sort);
        let bound = stage.bind(device, &config, &uniform, &from.0, &from.1, &digit_counts, &into.0, &into.1);
        gpu::run(|pass| stage.record(pass, &bound, &sort, n as u32));
        from = into;
    }
    (gpu::read(&from.0, n), gpu::read(&from.1, n))
}

/// Keys up to and with the largest, some many times.
fn keys(count: u32, largest: u32) -> Vec<u32> {
    (0..count).map(|i| (synthetic::hash(i) >> (i % 7)) % (largest + 1)).collect()
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn order_is_equal_for_all_sizes_and_any_number_of_digits() {
    for (count, largest) in SIZES.into_iter().map(|n| (n, 100)).chain([
        (1000, 1),
        (1000, 63),
        (1000, 4096),
        (70_000, 4095),
        (300_000, 400),
        (5000, 300_000),
    ]) {
        let keys = keys(count, largest);
        let (sorted_keys, sorted) = on_gpu(&keys, largest);
        let expected = cpu::sort_instances(&keys);
        assert_eq!(first_difference(&sorted_keys, &expected.0), None, "{count} keys up to {largest}");
        assert_eq!(first_difference(&sorted, &expected.1), None, "{count} keys up to {largest}");
    }
}

#[test]
fn equal_keys_stay_in_order() {
    let (keys, sorted) = cpu::sort_instances(&[3, 1, 3, 0, 1]);
    assert_eq!((keys, sorted), (vec![0, 1, 1, 3, 3], vec![3, 1, 4, 0, 2]));
    assert!(first_difference(&[3, 4, 1, 0, 2], &[3, 1, 4, 0, 2]).is_some(), "another order is seen");
}
