// A stable sort of the instances' numbers by their keys, digit after digit from the lowest: counts of each digit's values in
// each block, their prefix sums, then everyone to its place. Twin: crowd-stages/src/cpu/sort_instances.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> sort: SortPass;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
@group(0) @binding(3) var<storage, read> values: array<u32>;
// Of value d in block b: [d * block_count + b]; behind them the sums of each value.
@group(0) @binding(4) var<storage, read_write> digit_counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> sorted_values: array<u32>;

var<workgroup> digits: array<u32, SORT_BLOCK_SIZE>;
var<workgroup> places: array<u32, SORT_BLOCK_SIZE>;

fn block_count() -> u32 {
    return (config.instance_count + SORT_BLOCK_SIZE - 1u) / SORT_BLOCK_SIZE;
}

// The digit of entry i; one that no entry has past the end.
fn digit_of(i: u32) -> u32 {
    if i >= config.instance_count {
        return NONE;
    }
    return (keys[i] >> sort.shift) & ((1u << sort.bits) - 1u);
}

// Lanes before this one with the same digit.
fn rank_of(lane: u32) -> u32 {
    let digit = digits[lane];
    var rank = 0u;
    for (var other = 0u; other < lane; other++) {
        rank += select(0u, 1u, digits[other] == digit);
    }
    return rank;
}

@compute @workgroup_size(SORT_BLOCK_SIZE)
fn count_digits(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    digits[lane] = digit_of(block * SORT_BLOCK_SIZE + lane);
    places[lane] = 0u;
    workgroupBarrier();
    let digit = digits[lane];
    let rank = rank_of(lane);
    var is_last = digit != NONE;
    for (var other = lane + 1u; other < SORT_BLOCK_SIZE; other++) {
        is_last = is_last && digits[other] != digit;
    }
    if is_last {
        places[digit] = rank + 1u;
    }
    workgroupBarrier();
    if lane < (1u << sort.bits) && block < block_count() {
        digit_counts[lane * block_count() + block] = places[lane];
    }
}

// Inclusive scan of `places` over the group.
fn scan_group(lane: u32) {
    for (var step = 1u; step < SORT_BLOCK_SIZE; step *= 2u) {
        workgroupBarrier();
        var value = places[lane];
        if lane >= step {
            value += places[lane - step];
        }
        workgroupBarrier();
        places[lane] = value;
    }
    workgroupBarrier();
}

// A group for each value of the digit: each thread takes a run of blocks. Replaces each count by the sum of those before.
@compute @workgroup_size(SORT_BLOCK_SIZE)
fn scan_digits(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let digit = group_number(workgroup);
    let blocks = block_count();
    let run = (blocks + SORT_BLOCK_SIZE - 1u) / SORT_BLOCK_SIZE;
    let first = min(lane * run, blocks);
    let end = min(first + run, blocks);
    var total = 0u;
    for (var b = first; b < end; b++) {
        total += digit_counts[digit * blocks + b];
    }
    places[lane] = total;
    scan_group(lane);
    if lane == SORT_BLOCK_SIZE - 1u {
        digit_counts[(1u << sort.bits) * blocks + digit] = places[lane];
    }
    var base = 0u;
    if lane > 0u {
        base = places[lane - 1u];
    }
    for (var b = first; b < end; b++) {
        let count = digit_counts[digit * blocks + b];
        digit_counts[digit * blocks + b] = base;
        base += count;
    }
}

@compute @workgroup_size(SORT_BLOCK_SIZE)
fn move_entries(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let blocks = block_count();
    let i = block * SORT_BLOCK_SIZE + lane;
    digits[lane] = digit_of(i);
    places[lane] = 0u;
    if lane < (1u << sort.bits) {
        places[lane] = digit_counts[(1u << sort.bits) * blocks + lane];
    }
    scan_group(lane);
    if i >= config.instance_count {
        return;
    }
    let digit = digits[lane];
    var place = digit_counts[digit * blocks + block] + rank_of(lane);
    if digit > 0u {
        place += places[digit - 1u];
    }
    sorted_keys[place] = keys[i];
    sorted_values[place] = select(values[i], i, sort.is_first == 1u);
}
