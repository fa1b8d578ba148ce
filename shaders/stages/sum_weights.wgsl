// Sums of weights, coarsest vertex counts and visible instances: a tree a block, then one group over all blocks.
// Twin: crowd-stages/src/cpu/sum_weights.rs, which adds in the same order, so that equal weights give equal sums.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(2) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(3) var<storage, read> culled: array<CullRecord>;
@group(0) @binding(4) var<storage, read_write> block_sums: array<WeightSums>;
@group(0) @binding(5) var<storage, read_write> sums: WeightSums;

var<workgroup> weights: array<f32, BLOCK_SIZE>;
var<workgroup> mins: array<u32, BLOCK_SIZE>;
var<workgroup> visibles: array<u32, BLOCK_SIZE>;

fn reduce_tree(lane: u32) {
    for (var half = BLOCK_SIZE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            weights[lane] += weights[lane + half];
            mins[lane] = saturating_add(mins[lane], mins[lane + half]);
            visibles[lane] += visibles[lane + half];
        }
    }
    workgroupBarrier();
}

@compute @workgroup_size(BLOCK_SIZE)
fn sum_blocks(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * BLOCK_SIZE + lane;
    weights[lane] = 0.0;
    mins[lane] = 0u;
    visibles[lane] = 0u;
    if i < config.instance_count {
        let cull = culled[i];
        if cull.visible != 0u {
            weights[lane] = cull.weight;
            let character = characters[instances[i].character];
            let area_px2 = cull.area_px2;
            let dots = config.dot_area_px2;
            mins[lane] = least_spent(character, area_px2, dots, config.impostor_area_px2, config.budget_in);
            visibles[lane] = 1u;
        }
    }
    reduce_tree(lane);
    if lane == 0u && block * BLOCK_SIZE < config.instance_count {
        block_sums[block] = WeightSums(weights[0], mins[0], visibles[0], 0u, 0u, 0u, 0u, 0u);
    }
}

// One group. Each thread adds a run of blocks one by one, then the tree adds the threads.
@compute @workgroup_size(BLOCK_SIZE)
fn sum_all(@builtin(local_invocation_index) lane: u32) {
    let block_count = (config.instance_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let run = (block_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    var weight = 0.0;
    var min_count = 0u;
    var visible = 0u;
    for (var b = lane * run; b < min((lane + 1u) * run, block_count); b++) {
        weight += block_sums[b].weight;
        min_count = saturating_add(min_count, block_sums[b].min_vertex_count);
        visible += block_sums[b].visible_count;
    }
    weights[lane] = weight;
    mins[lane] = min_count;
    visibles[lane] = visible;
    reduce_tree(lane);
    if lane == 0u {
        sums = WeightSums(weights[0], mins[0], visibles[0], 0u, 0u, 0u, 0u, 0u);
    }
}
