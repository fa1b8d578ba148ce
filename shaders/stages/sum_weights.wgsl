// Sums of weights, coarsest vertex counts and visible instances: a tree a block, then one group over all blocks.
// Twin: crowd-stages/src/cpu/sum_weights.rs, which adds in the same order, so that equal weights give equal sums.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(2) var<storage, read> culled: array<CullRecord>;
@group(0) @binding(3) var<storage, read_write> block_sums: array<WeightSums>;
@group(0) @binding(4) var<storage, read_write> sums: WeightSums;

// Of a group that sums a block of 256 instances: each thread takes four.
const SUM_GROUP_SIZE: u32 = 64u;

// A sum of each thread.
var<workgroup> weights: array<f32, SUM_GROUP_SIZE>;
var<workgroup> mins: array<u32, SUM_GROUP_SIZE>;
var<workgroup> visibles: array<u32, SUM_GROUP_SIZE>;

fn add(a: WeightSums, b: WeightSums) -> WeightSums {
    let least = saturating_add(a.min_vertex_count, b.min_vertex_count);
    return WeightSums(a.weight + b.weight, least, a.visible_count + b.visible_count, 0u, 0u, 0u, 0u, 0u);
}

fn kept_sum(lane: u32) -> WeightSums {
    return WeightSums(weights[lane], mins[lane], visibles[lane], 0u, 0u, 0u, 0u, 0u);
}

fn keep_sum(lane: u32, sum: WeightSums) {
    weights[lane] = sum.weight;
    mins[lane] = sum.min_vertex_count;
    visibles[lane] = sum.visible_count;
}

// Halves onto halves, of eight.
fn add_eight(first: u32, step: u32) -> WeightSums {
    let a = add(kept_sum(first), kept_sum(first + 4u * step));
    let b = add(kept_sum(first + step), kept_sum(first + 5u * step));
    let c = add(kept_sum(first + 2u * step), kept_sum(first + 6u * step));
    let d = add(kept_sum(first + 3u * step), kept_sum(first + 7u * step));
    return add(add(a, c), add(b, d));
}

// The sum over all threads, for the first of them: eight times eight, since a barrier costs more than a few additions.
fn sum_group(lane: u32, sum: WeightSums) -> WeightSums {
    keep_sum(lane, sum);
    workgroupBarrier();
    if lane < 8u {
        keep_sum(lane, add_eight(lane, 8u));
    }
    workgroupBarrier();
    if lane == 0u {
        return add_eight(0u, 1u);
    }
    return sum;
}

fn sum_of(i: u32) -> WeightSums {
    if i >= config.instance_count || culled[i].visible == 0u {
        return WeightSums();
    }
    let area_px2 = culled[i].area_px2;
    let character = characters[culled[i].visible - 1u];
    let least = least_spent(character, area_px2, config.dot_area_px2, config.impostor_area_px2, config.budget_in);
    return WeightSums(culled[i].weight, least, 1u, 0u, 0u, 0u, 0u, 0u);
}

@compute @workgroup_size(SUM_GROUP_SIZE)
fn sum_blocks(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * BLOCK_SIZE + lane;
    let near = add(sum_of(i), sum_of(i + 2u * SUM_GROUP_SIZE));
    let sum = sum_group(lane, add(near, add(sum_of(i + SUM_GROUP_SIZE), sum_of(i + 3u * SUM_GROUP_SIZE))));
    if lane == 0u && block * BLOCK_SIZE < config.instance_count {
        block_sums[block] = sum;
    }
}

// Of one of 256 runs of blocks, one by one.
fn run_sum(number: u32) -> WeightSums {
    let block_count = (config.instance_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let run = (block_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    var sum = WeightSums();
    for (var b = number * run; b < min((number + 1u) * run, block_count); b++) {
        let block = block_sums[b];
        sum = add(sum, block);
    }
    return sum;
}

// One group: each thread takes four runs.
@compute @workgroup_size(SUM_GROUP_SIZE)
fn sum_all(@builtin(local_invocation_index) lane: u32) {
    let near = add(run_sum(lane), run_sum(lane + 2u * SUM_GROUP_SIZE));
    let sum = sum_group(lane, add(near, add(run_sum(lane + SUM_GROUP_SIZE), run_sum(lane + 3u * SUM_GROUP_SIZE))));
    if lane == 0u {
        sums = sum;
    }
}
