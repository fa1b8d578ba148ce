//! `sort_at_once` on the GPU against its twin: equal.

use crate::cases::{SIZES, first_difference};
use crowd_stages::dispatch::AT_ONCE_KEYS;
use crowd_stages::{BucketCounts, BucketRange, FrameConfig, cpu, gpu::SortAtOnce};
use crowd_tests::{gpu, synthetic};

type Sorted = (Vec<u32>, Vec<u32>, Vec<u32>, Vec<BucketRange>);

/// `room`: instances that buffers and dispatches are for.
fn on_gpu(keys: &[u32], bucket_count: u32, room: u32) -> Sorted {
    let (device, _) = gpu::device();
    let stage = SortAtOnce::new(device);
    let n = keys.len();
    let config = gpu::uniform(&FrameConfig { instance_count: n as u32, ..Default::default() });
    let counts = gpu::uniform(&BucketCounts { bucket_count, ..Default::default() });
    let key_counts = gpu::output::<u32>(SortAtOnce::count_words(room, bucket_count) as usize);
    let [sorted_keys, sorted, entries] = [(); 3].map(|()| gpu::output::<u32>(n));
    let ranges = gpu::storage(&vec![BucketRange { first: 7, end: 9 }; bucket_count as usize]);
    let keys = gpu::storage(keys);
    let bound = stage.bind(device, &config, &counts, &keys, &key_counts, &sorted_keys, &sorted, &entries, &ranges);
    gpu::run(|pass| stage.record(pass, &bound, room));
    let words = |buffer| gpu::read(buffer, n);
    (words(&sorted_keys), words(&sorted), words(&entries), gpu::read(&ranges, bucket_count as usize))
}

/// Whatever is not the same.
fn difference(a: &Sorted, b: &Sorted) -> Option<String> {
    let lists = [(&a.0, &b.0), (&a.1, &b.1), (&a.2, &b.2)].into_iter().find_map(|(a, b)| first_difference(a, b));
    lists.map(|at| format!("{at:?}")).or_else(|| first_difference(&a.3, &b.3).map(|at| format!("ranges {at:?}")))
}

#[test]
#[cfg_attr(crowd_no_gpu, ignore = "CROWD_NO_GPU=1: opted out of GPU tests")]
fn lists_places_and_ranges_are_equal_for_all_sizes() {
    let sizes = SIZES.into_iter().map(|n| (n, 100));
    for (count, buckets) in sizes.chain([(1000, 1), (1000, 345), (70_000, 345), (300_000, AT_ONCE_KEYS - 1)]) {
        // Some keys many times, some never; those in no bucket, too.
        let key = |i: u32| (synthetic::hash(i) >> (i % 7)) % buckets / 3 * 3;
        let keys: Vec<u32> = (0..count).map(|i| if i % 5 == 3 { buckets } else { key(i) }).collect();
        let expected = cpu::sort_at_once(&keys, buckets);
        for room in [count, count + 1, 2 * count + 5000] {
            let sorted = on_gpu(&keys, buckets, room);
            assert_eq!(difference(&sorted, &expected), None, "{count} keys, {buckets} buckets, room for {room}");
        }
    }
}

#[test]
fn places_say_who_went_where_and_another_place_is_seen() {
    let sorted = cpu::sort_at_once(&[3, 1, 3, 0, 1], 3);
    assert_eq!(sorted.1, [3, 1, 4, 0, 2]);
    assert_eq!(sorted.2, [3, 1, 4, 0, 2]);
    let range = |first, end| BucketRange { first, end };
    assert_eq!(sorted.3, [range(0, 1), range(1, 3), range(0, 0)]);
    let mut changed = sorted.clone();
    changed.2.swap(0, 1);
    assert!(difference(&changed, &sorted).is_some());
    changed = sorted.clone();
    changed.3[1].end = 4;
    assert!(difference(&changed, &sorted).is_some());
}
