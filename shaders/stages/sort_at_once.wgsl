// A stable sort of the instances' numbers by their keys in one pass, where keys are few: each thread counts the keys of a long run and has
// the counts to itself, so nobody waits for anybody. For adapters that are processors: what is dear there is to touch everyone once more.
// It also says where everyone went, and where each bucket's are. Twin: crowd-stages/src/cpu/sort_at_once.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
// Of key k in run r, at [r * key_count + k]: how many there are; then where the next of them goes.
@group(0) @binding(3) var<storage, read_write> key_counts: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_values: array<u32>;
// Of each instance, its place in the list.
@group(0) @binding(6) var<storage, read_write> entries: array<u32>;
@group(0) @binding(7) var<storage, read_write> ranges: array<BucketRange>;

// Those in no bucket have a key, too.
fn key_count() -> u32 {
    return bucket_counts.bucket_count + 1u;
}

fn run_length() -> u32 {
    return max((config.instance_count + AT_ONCE_RUNS - 1u) / AT_ONCE_RUNS, AT_ONCE_SHORTEST);
}

fn run_count() -> u32 {
    return (config.instance_count + run_length() - 1u) / run_length();
}

// The instances of a run.
fn run_of(number: u32) -> vec2u {
    let first = min(number * run_length(), config.instance_count);
    return vec2u(first, min(first + run_length(), config.instance_count));
}

@compute @workgroup_size(AT_ONCE_GROUP_SIZE)
fn count_keys(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = group_number(workgroup) * AT_ONCE_GROUP_SIZE + lane;
    if number >= run_count() {
        return;
    }
    let row = number * key_count();
    for (var key = 0u; key < key_count(); key++) {
        key_counts[row + key] = 0u;
    }
    let run = run_of(number);
    for (var i = run.x; i < run.y; i++) {
        key_counts[row + keys[i]]++;
    }
}

// One group: each thread takes some keys, one after another. Replaces each count by where the first of them goes.
@compute @workgroup_size(BLOCK_SIZE)
fn scan_keys(@builtin(local_invocation_index) lane: u32) {
    let each = (key_count() + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let first = min(lane * each, key_count());
    let end = min(first + each, key_count());
    var total = 0u;
    for (var key = first; key < end; key++) {
        for (var run = 0u; run < run_count(); run++) {
            total += key_counts[run * key_count() + key];
        }
    }
    lanes[lane] = total;
    scan_group(lane);
    var place = sum_before(lane);
    for (var key = first; key < end; key++) {
        let begin = place;
        for (var run = 0u; run < run_count(); run++) {
            let at = run * key_count() + key;
            let count = key_counts[at];
            key_counts[at] = place;
            place += count;
        }
        if key < bucket_counts.bucket_count {
            // Empty ones are so at zero.
            ranges[key] = BucketRange(select(0u, begin, place > begin), select(0u, place, place > begin));
        }
    }
}

@compute @workgroup_size(AT_ONCE_GROUP_SIZE)
fn move_at_once(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let number = group_number(workgroup) * AT_ONCE_GROUP_SIZE + lane;
    if number >= run_count() {
        return;
    }
    let row = number * key_count();
    let run = run_of(number);
    for (var i = run.x; i < run.y; i++) {
        let key = keys[i];
        let place = key_counts[row + key];
        key_counts[row + key] = place + 1u;
        sorted_keys[place] = key;
        sorted_values[place] = i;
        entries[i] = place;
    }
}
