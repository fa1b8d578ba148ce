// Arguments of one indirect draw a bucket, the draws that draw anything first, and the frame's totals.
// Twin: crowd-stages/src/cpu/write_bucket_args.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> sums: WeightSums;
@group(0) @binding(3) var<storage, read> buckets: array<BucketRecord>;
@group(0) @binding(4) var<storage, read> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> ranges: array<BucketRange>;
@group(0) @binding(6) var<storage, read_write> draw_args: array<DrawArgs>;
@group(0) @binding(7) var<storage, read_write> draw_counts: DrawCounts;
@group(0) @binding(8) var<storage, read_write> totals: FrameTotals;

// Instances, vertices, triangles.
var<workgroup> drawn: array<vec3u, BLOCK_SIZE>;

@compute @workgroup_size(BLOCK_SIZE)
fn clear_ranges(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let bucket = group_number(workgroup) * BLOCK_SIZE + lane;
    if bucket < bucket_counts.bucket_count {
        ranges[bucket] = BucketRange(0u, 0u);
    }
}

// Where one key ends and the next begins.
@compute @workgroup_size(BLOCK_SIZE)
fn find_ranges(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let key = sorted_keys[i];
    if key >= bucket_counts.bucket_count {
        return;
    }
    if i == 0u || sorted_keys[max(i, 1u) - 1u] != key {
        ranges[key].first = i;
    }
    if i + 1u == config.instance_count || sorted_keys[min(i + 1u, config.instance_count - 1u)] != key {
        ranges[key].end = i + 1u;
    }
}

fn saturating_multiply(a: u32, b: u32) -> u32 {
    return select(a * b, 0xffffffffu, b != 0u && a > 0xffffffffu / max(b, 1u));
}

// Buckets first..end, which are of one kind: each thread takes a run of them. How many of them draw anything.
fn write_draws(lane: u32, first: u32, end: u32) -> u32 {
    let run = (end - first + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let begin = min(first + lane * run, end);
    let stop = min(begin + run, end);
    var count = 0u;
    for (var b = begin; b < stop; b++) {
        count += select(0u, 1u, ranges[b].end > ranges[b].first);
    }
    workgroupBarrier();
    lanes[lane] = count;
    scan_group(lane);
    let all = sum_up_to(BLOCK_SIZE - 1u);
    let before = sum_before(lane);
    var place = first + before;
    // Empty ones fill the end.
    var empty_place = first + all + (begin - first) - before;
    var sum = drawn[lane];
    for (var b = begin; b < stop; b++) {
        let range = ranges[b];
        let instance_count = range.end - range.first;
        if instance_count == 0u {
            draw_args[empty_place] = DrawArgs(0u, 0u, 0u, 0, 0u);
            empty_place++;
            continue;
        }
        let bucket = buckets[b];
        draw_args[place] = DrawArgs(
            bucket.index_count,
            instance_count,
            bucket.first_index,
            i32(bucket.vertex_offset),
            range.first,
        );
        place++;
        sum.x += instance_count;
        sum.y = saturating_add(sum.y, saturating_multiply(instance_count, bucket.vertex_count));
        sum.z = saturating_add(sum.z, saturating_multiply(instance_count, bucket.triangle_count));
    }
    drawn[lane] = sum;
    return all;
}

// One group.
@compute @workgroup_size(BLOCK_SIZE)
fn write_args(@builtin(local_invocation_index) lane: u32) {
    drawn[lane] = vec3u(0u);
    let count_16 = write_draws(lane, 0u, bucket_counts.count_16);
    let count_32 = write_draws(lane, bucket_counts.count_16, bucket_counts.mesh_count);
    let dot_count = write_draws(lane, bucket_counts.mesh_count, bucket_counts.first_impostor);
    let impostor_count = write_draws(lane, bucket_counts.first_impostor, bucket_counts.first_fade);
    let fade_count = write_draws(lane, bucket_counts.first_fade, bucket_counts.bucket_count);
    for (var half = BLOCK_SIZE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            let a = drawn[lane];
            let b = drawn[lane + half];
            drawn[lane] = vec3u(a.x + b.x, saturating_add(a.y, b.y), saturating_add(a.z, b.z));
        }
    }
    workgroupBarrier();
    if lane == 0u {
        let all = drawn[0];
        let over = select(0u, OVERFLOW_BUDGET, sums.min_vertex_count > config.budget);
        draw_counts = DrawCounts(count_16, count_32, dot_count, impostor_count, fade_count);
        let draws = count_16 + count_32 + dot_count + impostor_count + fade_count;
        let wanted = sums.wanted_count;
        totals = FrameTotals(
            all.x,
            all.y,
            all.z,
            sums.min_vertex_count,
            over,
            all.y,
            all.z,
            draws,
            wanted,
            threshold_px(config.weight, sums.water_bits),
            0u,
            config.instance_count - all.x,
            0u,
        );
    }
}
