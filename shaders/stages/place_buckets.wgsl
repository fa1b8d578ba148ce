// Where the skinned vertices of each bucket lie: bucket after bucket in the order of the sorted list, whole buckets while there is
// room. One group. Twin: crowd-stages/src/cpu/place_buckets.rs.

@group(0) @binding(0) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(1) var<uniform> capacities: Capacities;
@group(0) @binding(2) var<storage, read> buckets: array<BucketRecord>;
@group(0) @binding(3) var<storage, read> ranges: array<BucketRange>;
// One more than there are buckets: where the last one ends.
@group(0) @binding(4) var<storage, read_write> places: array<BucketPlace>;
@group(0) @binding(5) var<storage, read_write> dispatch: DispatchArgs;
@group(0) @binding(6) var<storage, read_write> totals: FrameTotals;

// Who has no place here is drawn all the same, skinned in the vertex shader.
override DRAWS_THE_REST: bool = false;

var<workgroup> kept: array<u32, BLOCK_SIZE>;

// Dots have no vertices to skin.
fn vertices_of(bucket: u32) -> u32 {
    if bucket >= bucket_counts.mesh_count {
        return 0u;
    }
    let instance_count = ranges[bucket].end - ranges[bucket].first;
    if instance_count > 0u && ranges[bucket].end > bucket_counts.palette_slots {
        // Vertices come from palettes: nobody behind the last of these has a place, as if there were no room.
        return NONE - 1u;
    }
    let vertex_count = buckets[bucket].vertex_count;
    // Saturates: a bucket that large has no room anyway.
    return select(instance_count * vertex_count, NONE - 1u, instance_count > (NONE - 1u) / max(vertex_count, 1u));
}

@compute @workgroup_size(BLOCK_SIZE)
fn place_buckets(@builtin(local_invocation_index) lane: u32) {
    // Each thread takes a run of buckets.
    let run = (bucket_counts.bucket_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let begin = min(lane * run, bucket_counts.bucket_count);
    let stop = min(begin + run, bucket_counts.bucket_count);
    var sum = 0u;
    for (var b = begin; b < stop; b++) {
        sum = saturating_add(sum, vertices_of(b));
    }
    lanes[lane] = sum;
    scan_group(lane);
    var base = sum_before(lane);
    kept[lane] = 0u;
    for (var b = begin; b < stop; b++) {
        let end = saturating_add(base, vertices_of(b));
        let fits = end <= capacities.vertex_count;
        places[b] = BucketPlace(
            select(NONE, base, fits),
            ranges[b].first,
            buckets[b].vertex_count,
            buckets[b].vertex_offset,
        );
        kept[lane] = select(kept[lane], end, fits);
        base = end;
    }
    // Ends never decrease, so the largest one kept is where it ends.
    for (var half = BLOCK_SIZE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            kept[lane] = max(kept[lane], kept[lane + half]);
        }
    }
    workgroupBarrier();
    if lane == 0u {
        places[bucket_counts.bucket_count] = BucketPlace(kept[0], 0u, 0u, 0u);
        let groups = kept[0] / BLOCK_SIZE + select(0u, 1u, kept[0] % BLOCK_SIZE > 0u);
        dispatch = DispatchArgs(min(groups, FOLD_COLUMNS), (groups + FOLD_COLUMNS - 1u) / FOLD_COLUMNS, 1u);
        if !DRAWS_THE_REST && sum_up_to(BLOCK_SIZE - 1u) > capacities.vertex_count {
            totals.overflow |= OVERFLOW_VERTICES;
        }
    }
}
