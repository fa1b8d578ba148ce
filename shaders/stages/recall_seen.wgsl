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
// Arguments of the second phase's dispatches: zeros where nobody waits for it.
@group(0) @binding(8) var<storage, read_write> gate: array<u32, 9>;

// Of a group that goes through a block of 256 instances, or of blocks' tallies: each thread takes four.
const RECALL_GROUP_SIZE: u32 = 64u;

// A tally of each thread.
var<workgroup> kept: array<SightTally, RECALL_GROUP_SIZE>;

fn add(a: SightTally, b: SightTally) -> SightTally {
    return SightTally(saturating_add(a.hidden_min_count, b.hidden_min_count), a.hidden_count + b.hidden_count);
}

// The sum over all threads, for the first of them: eight times eight, since a barrier costs more than a few additions.
fn sum_group(lane: u32, tally: SightTally) -> SightTally {
    kept[lane] = tally;
    workgroupBarrier();
    if lane < 8u {
        var sum = kept[lane];
        for (var other = lane + 8u; other < RECALL_GROUP_SIZE; other += 8u) {
            let one = kept[other];
            sum = add(sum, one);
        }
        kept[lane] = sum;
    }
    workgroupBarrier();
    var sum = kept[0];
    for (var other = 1u; other < 8u; other++) {
        let one = kept[other];
        sum = add(sum, one);
    }
    return sum;
}

// Who was hidden waits.
fn recalled(i: u32) -> SightTally {
    if i >= config.instance_count || seen[0] != config.instance_count {
        return SightTally();
    }
    if (seen[1u + i] & SIGHT_HIDDEN) == 0u || culled[i].visible == 0u {
        return SightTally();
    }
    // The weight stays: it tells who waits from who is outside.
    culled[i].visible = 0u;
    let character = characters[instances[i].character];
    let area_px2 = culled[i].area_px2;
    let dots = config.dot_area_px2;
    return SightTally(least_spent(character, area_px2, dots, config.impostor_area_px2, config.budget_in), 1u);
}

@compute @workgroup_size(RECALL_GROUP_SIZE)
fn recall(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    var sum = SightTally();
    for (var i = block * BLOCK_SIZE + lane; i < (block + 1u) * BLOCK_SIZE; i += RECALL_GROUP_SIZE) {
        sum = add(sum, recalled(i));
    }
    sum = sum_group(lane, sum);
    if lane == 0u && block * BLOCK_SIZE < config.instance_count {
        block_tallies[block] = sum;
    }
}

fn let_through(entry: u32, groups: u32) {
    gate[3u * entry] = min(groups, FOLD_COLUMNS);
    gate[3u * entry + 1u] = (groups + FOLD_COLUMNS - 1u) / FOLD_COLUMNS;
    gate[3u * entry + 2u] = select(0u, 1u, groups > 0u);
}

// Groups of a block each, one, and those of the sort in one pass; none for no instances.
fn set_gate(count: u32) {
    let run = max((count + AT_ONCE_RUNS - 1u) / AT_ONCE_RUNS, AT_ONCE_SHORTEST);
    let runs = (count + run - 1u) / run;
    let_through(0u, (count + BLOCK_SIZE - 1u) / BLOCK_SIZE);
    let_through(1u, min(count, 1u));
    let_through(2u, (runs + AT_ONCE_GROUP_SIZE - 1u) / AT_ONCE_GROUP_SIZE);
}

// One group. Each thread adds every 64th block.
@compute @workgroup_size(RECALL_GROUP_SIZE)
fn reserve(@builtin(local_invocation_index) lane: u32) {
    let block_count = (config.instance_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    var sum = SightTally();
    for (var b = lane; b < block_count; b += RECALL_GROUP_SIZE) {
        let block = block_tallies[b];
        sum = add(sum, block);
    }
    sum = sum_group(lane, sum);
    if lane == 0u {
        tally = sum;
        set_gate(select(0u, config.instance_count, sum.hidden_count > 0u));
        first_config = config;
        let kept_count = min(sum.hidden_min_count, config.budget / RESERVE_PART);
        first_config.budget = config.budget - kept_count;
        // What is kept is part of what may be left.
        first_config.slack = config.slack - min(config.slack, kept_count);
    }
}
