// Palettes and skinned vertices for leaders alone, where their followers find them. Twin: crowd-stages/src/cpu/share_poses.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
// Leaders in all.
@group(0) @binding(2) var<uniform> leader_end: InstanceBase;
@group(0) @binding(3) var<storage, read> ranges: array<BucketRange>;
// Leaders before each entry.
@group(0) @binding(4) var<storage, read> leaders_before: array<InstanceBase>;
@group(0) @binding(5) var<storage, read> sorted_keys: array<u32>;
@group(0) @binding(6) var<storage, read> places: array<BucketPlace>;
@group(0) @binding(7) var<storage, read_write> leader_ranges: array<BucketRange>;
@group(0) @binding(8) var<storage, read_write> drawn: array<DrawnInstance>;
// The entry of each leader.
@group(0) @binding(9) var<storage, read_write> leaders: array<u32>;

fn leaders_up_to(entry: u32) -> u32 {
    if entry >= config.instance_count {
        return leader_end.vertex_base;
    }
    return leaders_before[entry].vertex_base;
}

// The leaders of each bucket, as the instances of each bucket are in `ranges`.
@compute @workgroup_size(BLOCK_SIZE)
fn range_leaders(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let bucket = group_number(workgroup) * BLOCK_SIZE + lane;
    if bucket >= bucket_counts.bucket_count {
        return;
    }
    let range = ranges[bucket];
    if range.end == range.first {
        leader_ranges[bucket] = BucketRange(0u, 0u);
        return;
    }
    leader_ranges[bucket] = BucketRange(leaders_up_to(range.first), leaders_up_to(range.end));
}

// Everyone drawn is sent to the palette and the vertices of their leader.
@compute @workgroup_size(BLOCK_SIZE)
fn follow_leaders(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let entry = group_number(workgroup) * BLOCK_SIZE + lane;
    if entry >= config.instance_count {
        return;
    }
    let key = sorted_keys[entry];
    if key >= bucket_counts.bucket_count {
        return;
    }
    let end = leaders_up_to(entry + 1u);
    let leads = end > leaders_before[entry].vertex_base;
    // Entry 0 leads, so there is one.
    let leader = end - 1u;
    let place = places[key];
    // Impostors have other words there.
    if key < bucket_counts.first_impostor {
        drawn[entry].palette_row = palette_row(leader, bucket_counts);
        if place.vertex_base != NONE {
            drawn[entry].vertex_base = place.vertex_base + (leader - place.first) * place.vertex_count;
        }
    }
    if leads {
        leaders[leader] = entry;
    } else {
        // Nothing to blend for those who follow.
        drawn[entry].row_count = 0u;
    }
}
