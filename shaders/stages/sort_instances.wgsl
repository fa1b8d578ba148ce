// A stable sort of the instances' numbers by their keys, digit after digit from the lowest: counts of each digit's values in
// each block, their prefix sums, then everyone to its place. Twin: crowd-stages/src/cpu/sort_instances.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> sort: SortPass;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
@group(0) @binding(3) var<storage, read> values: array<u32>;
// Of value d in block b: [d * block_count + b]; behind them the sums of each value, which `scan_values` replaces by those of all values before it.
@group(0) @binding(4) var<storage, read_write> digit_counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(6) var<storage, read_write> sorted_values: array<u32>;

var<workgroup> places: array<u32, SORT_BLOCK_SIZE>;
var<workgroup> tallies: array<atomic<u32>, SORT_BLOCK_SIZE>;
// Which lanes have an entry, two words; then which have each of the digit's bits set.
var<workgroup> votes: array<atomic<u32>, 14>;

fn block_count() -> u32 {
    return (config.instance_count + SORT_BLOCK_SIZE - 1u) / SORT_BLOCK_SIZE;
}

fn digit_of(i: u32) -> u32 {
    return (keys[i] >> sort.shift) & ((1u << sort.bits) - 1u);
}

// Sums of ones come out alike in any order.
@compute @workgroup_size(SORT_BLOCK_SIZE)
fn count_digits(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * SORT_BLOCK_SIZE + lane;
    atomicStore(&tallies[lane], 0u);
    workgroupBarrier();
    if i < config.instance_count {
        atomicAdd(&tallies[digit_of(i)], 1u);
    }
    workgroupBarrier();
    if lane < (1u << sort.bits) && block < block_count() {
        digit_counts[lane * block_count() + block] = atomicLoad(&tallies[lane]);
    }
}

fn vote(number: u32, lane: u32) {
    atomicOr(&votes[2u * number + lane / 32u], 1u << (lane % 32u));
}

fn voters(number: u32) -> vec2u {
    return vec2u(atomicLoad(&votes[2u * number]), atomicLoad(&votes[2u * number + 1u]));
}

// Lanes before this one with the same digit; everyone has voted.
fn rank_of(lane: u32, digit: u32) -> u32 {
    var same = voters(0u);
    for (var bit = 0u; bit < sort.bits; bit++) {
        let with_bit = voters(1u + bit);
        same &= select(~with_bit, with_bit, ((digit >> bit) & 1u) == 1u);
    }
    let below = (1u << (lane % 32u)) - 1u;
    let ones = countOneBits(same & select(vec2u(below, 0u), vec2u(0xffffffffu, below), lane >= 32u));
    return ones.x + ones.y;
}

// Inclusive scan of `places` over the group by one lane: sixty-four sums take less time than a dozen barriers.
fn scan_group(lane: u32) {
    workgroupBarrier();
    if lane == 0u {
        var sum = 0u;
        for (var other = 0u; other < SORT_BLOCK_SIZE; other++) {
            sum += places[other];
            places[other] = sum;
        }
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

// One group. Replaces the sum of each value by that of all before it: once, instead of in every block.
@compute @workgroup_size(SORT_BLOCK_SIZE)
fn scan_values(@builtin(local_invocation_index) lane: u32) {
    let is_value = lane < (1u << sort.bits);
    let at = (1u << sort.bits) * block_count() + lane;
    var sum = 0u;
    if is_value {
        sum = digit_counts[at];
    }
    places[lane] = sum;
    scan_group(lane);
    if is_value {
        digit_counts[at] = places[lane] - sum;
    }
}

@compute @workgroup_size(SORT_BLOCK_SIZE)
fn move_entries(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let blocks = block_count();
    let i = block * SORT_BLOCK_SIZE + lane;
    let has_entry = i < config.instance_count;
    var digit = 0u;
    if lane < 14u {
        atomicStore(&votes[lane], 0u);
    }
    workgroupBarrier();
    if has_entry {
        digit = digit_of(i);
        vote(0u, lane);
        for (var bit = 0u; bit < sort.bits; bit++) {
            if ((digit >> bit) & 1u) == 1u {
                vote(1u + bit, lane);
            }
        }
    }
    workgroupBarrier();
    if !has_entry {
        return;
    }
    let first = digit_counts[(1u << sort.bits) * blocks + digit];
    let place = first + digit_counts[digit * blocks + block] + rank_of(lane, digit);
    sorted_keys[place] = keys[i];
    sorted_values[place] = select(values[i], i, sort.is_first == 1u);
}
