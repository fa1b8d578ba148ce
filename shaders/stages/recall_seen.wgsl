// Who was hidden in the last frame waits for the second phase, and a little of the budget is kept for those who will come
// into sight. Twin: crowd-stages/src/cpu/recall_seen.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(2) var<storage, read> characters: array<CharacterRecord>;
// The number of instances it is valid for, then a word for each.
@group(0) @binding(3) var<storage, read> seen: array<u32>;
@group(0) @binding(4) var<storage, read_write> culled: array<CullRecord>;
@group(0) @binding(5) var<storage, read_write> block_tallies: array<SightTally>;
@group(0) @binding(6) var<storage, read_write> tally: SightTally;
// The same frame with what is left of the budget.
@group(0) @binding(7) var<storage, read_write> first_config: FrameConfig;

var<workgroup> mins: array<u32, BLOCK_SIZE>;
var<workgroup> counts: array<u32, BLOCK_SIZE>;

fn reduce_tree(lane: u32) {
    for (var half = BLOCK_SIZE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            mins[lane] = saturating_add(mins[lane], mins[lane + half]);
            counts[lane] += counts[lane + half];
        }
    }
    workgroupBarrier();
}

@compute @workgroup_size(BLOCK_SIZE)
fn recall(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * BLOCK_SIZE + lane;
    mins[lane] = 0u;
    counts[lane] = 0u;
    if i < config.instance_count && seen[0] == config.instance_count {
        let was_hidden = (seen[1u + i] & SIGHT_HIDDEN) != 0u;
        if was_hidden && culled[i].visible != 0u {
            // The weight stays: it tells who waits from who is outside.
            culled[i].visible = 0u;
            let character = characters[instances[i].character];
            let area_px2 = culled[i].area_px2;
            let dots = config.dot_area_px2;
            mins[lane] = least_spent(character, area_px2, dots, config.impostor_area_px2, config.budget_in);
            counts[lane] = 1u;
        }
    }
    reduce_tree(lane);
    if lane == 0u && block * BLOCK_SIZE < config.instance_count {
        block_tallies[block] = SightTally(mins[0], counts[0]);
    }
}

// One group. Each thread adds a run of blocks one by one, then the tree adds the threads.
@compute @workgroup_size(BLOCK_SIZE)
fn reserve(@builtin(local_invocation_index) lane: u32) {
    let block_count = (config.instance_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let run = (block_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    mins[lane] = 0u;
    counts[lane] = 0u;
    for (var b = lane * run; b < min((lane + 1u) * run, block_count); b++) {
        mins[lane] = saturating_add(mins[lane], block_tallies[b].hidden_min_count);
        counts[lane] += block_tallies[b].hidden_count;
    }
    reduce_tree(lane);
    if lane == 0u {
        tally = SightTally(mins[0], counts[0]);
        first_config = config;
        let kept = min(mins[0], config.budget / RESERVE_PART);
        first_config.budget = config.budget - kept;
        // What is kept is part of what may be left.
        first_config.slack = config.slack - min(config.slack, kept);
    }
}
