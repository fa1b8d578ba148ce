//! Where the skinned vertices of each bucket lie.

use crate::dispatch::{BLOCK_SIZE, FOLD_COLUMNS};
use crate::{BucketPlace, BucketRange, Buckets, DispatchArgs, overflow};
use crowd_pack::NONE;

/// A place for each bucket's vertices, bucket after bucket, then one that says where the last ends; the groups that skin them; and
/// overflow bits, which the stage keeps to itself where the vertex shader draws those who have no place.
///
/// `ranges`: of `write_bucket_args`, or of `range_leaders`: either way, numbers of palettes. `vertex_capacity`: vertices there is room for. Whole
/// buckets are placed while they and their palettes fit; none after the first that does not.
///
/// Paper: Dong 2019 §4.3 places vertices by prefix sums over instances; over buckets there are fewer.
/// Twin: `shaders/stages/place_buckets.wgsl`. Equal.
pub fn place_buckets(
    buckets: &Buckets,
    ranges: &[BucketRange],
    vertex_capacity: u32,
) -> (Vec<BucketPlace>, DispatchArgs, u32) {
    let (mut end, mut kept) = (0u32, 0);
    let mut places = Vec::with_capacity(ranges.len() + 1);
    for (bucket, (record, range)) in (0..).zip(buckets.records.iter().zip(ranges)) {
        let base = end;
        // The largest number is kept for places that there are not.
        let instance_count = if bucket < buckets.mesh_count { range.end - range.first } else { 0 };
        // Vertices come from palettes: nobody behind the last of these has a place.
        let has_palettes = instance_count == 0 || range.end <= buckets.palette_slots;
        let needed = if has_palettes { u64::from(instance_count) * u64::from(record.vertex_count) } else { u64::MAX };
        end = end.saturating_add(u32::try_from(needed).unwrap_or(NONE - 1).min(NONE - 1));
        let fits = end <= vertex_capacity;
        kept = if fits { end } else { kept };
        places.push(BucketPlace {
            vertex_base: if fits { base } else { NONE },
            first: range.first,
            vertex_count: record.vertex_count,
            vertex_offset: record.vertex_offset,
        });
    }
    places.push(BucketPlace { vertex_base: kept, ..Default::default() });
    let groups = kept.div_ceil(BLOCK_SIZE);
    let dispatch = DispatchArgs { x: groups.min(FOLD_COLUMNS), y: groups.div_ceil(FOLD_COLUMNS), z: 1 };
    (places, dispatch, if end > vertex_capacity { overflow::VERTICES } else { 0 })
}
