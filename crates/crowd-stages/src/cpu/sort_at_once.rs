//! Instances of a bucket side by side, and where each of them went.

use super::sort_instances;
use crate::BucketRange;

/// What [`sort_instances`] gives, the place of each instance in that list, and where each bucket's are in it: zeros where there are none.
///
/// `keys`: of instances, below `bucket_count`; or just that, of those in no bucket.
///
/// Paper: Park & Han 2009 §3.2, the second phase, there one geometry-shader pass per LOD. Departs: a counting sort over all keys at once.
/// Twin: `shaders/stages/sort_at_once.wgsl`. Equal.
pub fn sort_at_once(keys: &[u32], bucket_count: u32) -> (Vec<u32>, Vec<u32>, Vec<u32>, Vec<BucketRange>) {
    let (sorted_keys, sorted) = sort_instances(keys);
    let mut entries = vec![0; keys.len()];
    let mut ranges = vec![BucketRange::default(); bucket_count as usize];
    for (place, (key, i)) in (0..).zip(sorted_keys.iter().zip(&sorted)) {
        entries[*i as usize] = place;
        if let Some(range) = ranges.get_mut(*key as usize) {
            range.first = if range.end == 0 { place } else { range.first };
            range.end = place + 1;
        }
    }
    (sorted_keys, sorted, entries, ranges)
}
