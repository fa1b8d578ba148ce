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

// Entries of a group's block.
const SORT_ENTRIES: u32 = SORT_BLOCK_SIZE * SORT_RUN;

var<workgroup> places: array<u32, SORT_BLOCK_SIZE>;
// Of value d and thread t, at `tally_at`: how many entries of its run have it; then where the next of them goes. Each thread has numbers of its
// own: an atomic that it shares is dear on software Vulkan. All 16 KiB that a group may have everywhere: no entry point may use both arrays.
var<workgroup> tallies: array<u32, SORT_BLOCK_SIZE * SORT_BLOCK_SIZE>;

fn block_count() -> u32 {
    return (config.instance_count + SORT_ENTRIES - 1u) / SORT_ENTRIES;
}

fn value_count() -> u32 {
    return 1u << sort.bits;
}

// Turned by the value, so that neither threads of one value nor values of one thread wait for each other.
fn tally_at(value: u32, thread: u32) -> u32 {
    return value * SORT_BLOCK_SIZE + (thread + value) % SORT_BLOCK_SIZE;
}

fn digit_of(i: u32) -> u32 {
    return (keys[i] >> sort.shift) & ((1u << sort.bits) - 1u);
}

// The entries of a thread's run.
fn run_of(block: u32, lane: u32) -> vec2u {
    let first = min(block * SORT_ENTRIES + lane * SORT_RUN, config.instance_count);
    return vec2u(first, min(first + SORT_RUN, config.instance_count));
}

// Each thread counts its own run; then thread d has the counts of value d to itself.
fn tally(lane: u32, run: vec2u) {
    for (var value = 0u; value < value_count(); value++) {
        tallies[tally_at(value, lane)] = 0u;
    }
    for (var i = run.x; i < run.y; i++) {
        tallies[tally_at(digit_of(i), lane)]++;
    }
    workgroupBarrier();
}

@compute @workgroup_size(SORT_BLOCK_SIZE)
fn count_digits(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    tally(lane, run_of(block, lane));
    if lane < value_count() && block < block_count() {
        var sum = 0u;
        for (var thread = 0u; thread < SORT_BLOCK_SIZE; thread++) {
            sum += tallies[tally_at(lane, thread)];
        }
        digit_counts[lane * block_count() + block] = sum;
    }
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
    let run = run_of(block, lane);
    tally(lane, run);
    if lane < value_count() && block < block_count() {
        var place = digit_counts[value_count() * block_count() + lane] + digit_counts[lane * block_count() + block];
        for (var thread = 0u; thread < SORT_BLOCK_SIZE; thread++) {
            let at = tally_at(lane, thread);
            let count = tallies[at];
            tallies[at] = place;
            place += count;
        }
    }
    workgroupBarrier();
    for (var i = run.x; i < run.y; i++) {
        let key = keys[i];
        let at = tally_at((key >> sort.shift) & (value_count() - 1u), lane);
        let place = tallies[at];
        tallies[at] = place + 1u;
        sorted_keys[place] = key;
        sorted_values[place] = select(values[i], i, sort.is_first == 1u);
    }
}
