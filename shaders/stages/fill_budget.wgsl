// Water filling: the highest level of water (vertices a unit of weight; they or their triangles count) at which the crowd fits the budget, by three passes
// over sixteen candidates each; what is left goes to the first instances as a step towards the next candidate.
// Integers and single products only, so the twin is equal. Twin: crowd-stages/src/cpu/fill_budget.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(2) var<storage, read> characters: array<CharacterRecord>;
// LodRecords as words, so that the one that counts is fetched by its number.
@group(0) @binding(3) var<storage, read> lods: array<u32>;
@group(0) @binding(4) var<storage, read> culled: array<CullRecord>;
// Sixteen sums a block; then one step a block.
@group(0) @binding(5) var<storage, read_write> block_counts: array<u32>;
@group(0) @binding(6) var<storage, read_write> fill: FillState;
@group(0) @binding(7) var<storage, read_write> sums: WeightSums;
@group(0) @binding(8) var<storage, read_write> choices: array<LodChoice>;

// Of a group that sums a block of 256 instances at all candidates: each thread takes four.
const FILL_GROUP_SIZE: u32 = 64u;
// Bits of 2^80: far above what fills any level, and no product with a weight overflows.
const HIGHEST_BITS: u32 = 0x67800000u;

var<workgroup> lane_counts: array<u32, 1024>;

fn block_count() -> u32 {
    return (config.instance_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
}

// Bits of 2^exponent; of 0 below the range, the highest above it.
fn power_bits(exponent: i32) -> u32 {
    return u32(clamp(exponent + 127, 0, i32(HIGHEST_BITS >> 23u))) << 23u;
}

fn exponent_of(value: f32) -> i32 {
    return i32((bitcast<u32>(value) >> 23u) & 0xffu) - 127;
}

// Whether the water may stay where it was.
fn has_before() -> bool {
    return config.slack > 0u && config.water_before_bits > 0u;
}

// The first candidates: powers of two around Eq. 1's level, then the highest, and Eq. 1's own, to tell what it comes to. Where the
// water may stay, its height before comes first.
@compute @workgroup_size(1)
fn begin() {
    let around = exponent_of(f32(config.budget)) - exponent_of(sums.weight);
    fill.low_bits = 0u;
    fill.high_bits = HIGHEST_BITS;
    fill.low_count = sums.min_vertex_count;
    fill.high_count = 0xffffffffu;
    fill.pass_number = 0u;
    fill.goal = config.budget;
    for (var c = 0u; c < FILL_CANDIDATES - 2u; c++) {
        fill.candidates[c] = power_bits(around + i32(c) - 6);
    }
    if has_before() {
        fill.candidates[0] = min(config.water_before_bits, HIGHEST_BITS);
    }
    fill.candidates[FILL_CANDIDATES - 2u] = HIGHEST_BITS;
    fill.candidates[FILL_CANDIDATES - 1u] = 0u;
    if sums.weight > 0.0 {
        let plain = clamp(f32(config.budget) / sums.weight, 0.0, bitcast<f32>(HIGHEST_BITS));
        fill.candidates[FILL_CANDIDATES - 1u] = bitcast<u32>(plain);
    }
}

// Vertices, or triangles where `in_triangles` is BUDGET_TRIANGLES, of an instance that is small on the screen: of its impostor, with the coarsest mesh
// on the way there; of one dot where it may be dots and the water is too low.
fn impostor_count(one: Weighed, product: f32, in_triangles: u32) -> u32 {
    let is_short = one.may_be_dots && product < f32(one.min_vertex_count);
    let alone = select(IMPOSTOR_VERTICES, IMPOSTOR_TRIANGLES, in_triangles == BUDGET_TRIANGLES);
    let dot = select(DOT_VERTICES, 1u, in_triangles == BUDGET_TRIANGLES);
    let is_dot = one.may_be_dots && product < f32(IMPOSTOR_VERTICES);
    let mesh = select(one.min_vertex_count, one.min_triangle_count, in_triangles == BUDGET_TRIANGLES);
    return select(select(alone, dot, is_dot), alone + mesh, one.fades && !is_short);
}

// What the search needs to know of an instance.
struct Weighed {
    weight: f32,
    // Counts of vertices between which its level lies.
    least: f32,
    most: f32,
    // Of its entries in the table of levels; of the error tables.
    first_entry: u32,
    character: u32,
    // Whether it is its impostor, or on the way there; whether it may be dots.
    stands_in: bool,
    fades: bool,
    may_be_dots: bool,
    min_vertex_count: u32,
    min_triangle_count: u32,
}

fn weighed(i: u32) -> Weighed {
    let number = instances[i].character;
    let area_px2 = culled[i].area_px2;
    let min_vertex_count = characters[number].min_vertex_count;
    return Weighed(
        culled[i].weight,
        f32(least_count(min_vertex_count, area_px2, config.dot_area_px2, 0.0)),
        f32(characters[number].vertex_count),
        characters[number].lod_offset,
        number,
        config.weight != WEIGHT_ERROR && stands_in(min_vertex_count, area_px2, config.impostor_area_px2),
        area_px2 >= config.impostor_area_px2,
        area_px2 < config.dot_area_px2,
        min_vertex_count,
        characters[number].min_triangle_count,
    );
}

// Vertices or triangles of its level in water that high. One fetch and no branch: adapters that work on groups of lanes go through all of them.
// Of the error metric, the height is one over pixels: its product with the pixels a metre takes is one over the metres allowed.
fn count_in(one: Weighed, bits: u32, in_triangles: u32) -> u32 {
    let product = one.weight * bitcast<f32>(bits);
    let k = max(min(product, one.most), one.least);
    let entry = select(one.first_entry + u32(k), error_entry(one.character, product), config.weight == WEIGHT_ERROR);
    let count = lods[2u * entry + in_triangles];
    return select(count, impostor_count(one, product, in_triangles), one.stands_in);
}

// What an instance takes of the budget in water that high.
fn spent_in(one: Weighed, bits: u32) -> u32 {
    return count_in(one, bits, select(0u, 1u, config.budget_in == BUDGET_TRIANGLES));
}

// The same in water of four heights.
fn counts_in(one: Weighed, bits: vec4u) -> vec4u {
    return vec4u(spent_in(one, bits.x), spent_in(one, bits.y), spent_in(one, bits.z), spent_in(one, bits.w));
}

fn saturating_add_4(a: vec4u, b: vec4u) -> vec4u {
    let sum = a + b;
    return select(sum, vec4u(0xffffffffu), sum < a);
}

fn candidates_from(first: u32) -> vec4u {
    return vec4u(
        fill.candidates[first],
        fill.candidates[first + 1u],
        fill.candidates[first + 2u],
        fill.candidates[first + 3u],
    );
}

fn keep_lane_counts(first: u32, counts: vec4u) {
    for (var c = 0u; c < 4u; c++) {
        lane_counts[first + c] = counts[c];
    }
}

// Whether nothing is left to search, as where the water stays: all candidates are one height, and what it comes to is known.
fn is_found() -> bool {
    return fill.pass_number > 0u && fill.low_bits == fill.high_bits;
}

// The sixteen sums are four vectors, which stay in registers; an array would not.
@compute @workgroup_size(FILL_GROUP_SIZE)
fn sum_candidates(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let bits_a = candidates_from(0u);
    let bits_b = candidates_from(4u);
    let bits_c = candidates_from(8u);
    let bits_d = candidates_from(12u);
    var counts_a = vec4u();
    var counts_b = vec4u();
    var counts_c = vec4u();
    var counts_d = vec4u();
    // Where the water stays, nobody is looked at.
    let end = select(BLOCK_SIZE, 0u, is_found());
    for (var part = lane; part < end; part += FILL_GROUP_SIZE) {
        let i = block * BLOCK_SIZE + part;
        if i >= config.instance_count || culled[i].visible == 0u {
            continue;
        }
        let one = weighed(i);
        counts_a = saturating_add_4(counts_a, counts_in(one, bits_a));
        counts_b = saturating_add_4(counts_b, counts_in(one, bits_b));
        counts_c = saturating_add_4(counts_c, counts_in(one, bits_c));
        counts_d = saturating_add_4(counts_d, counts_in(one, bits_d));
    }
    keep_lane_counts(lane * FILL_CANDIDATES, counts_a);
    keep_lane_counts(lane * FILL_CANDIDATES + 4u, counts_b);
    keep_lane_counts(lane * FILL_CANDIDATES + 8u, counts_c);
    keep_lane_counts(lane * FILL_CANDIDATES + 12u, counts_d);
    workgroupBarrier();
    if lane < FILL_CANDIDATES && block < block_count() {
        var sum = 0u;
        for (var l = 0u; l < FILL_GROUP_SIZE; l++) {
            sum = saturating_add(sum, lane_counts[l * FILL_CANDIDATES + lane]);
        }
        block_counts[block * FILL_CANDIDATES + lane] = sum;
    }
}

// One group: threads c, c + 16, ... add the blocks' sums of candidate c. Then between which two the budget lies.
@compute @workgroup_size(BLOCK_SIZE)
fn narrow(@builtin(local_invocation_index) lane: u32) {
    let candidate = lane % FILL_CANDIDATES;
    let chunks = BLOCK_SIZE / FILL_CANDIDATES;
    var sum = 0u;
    for (var b = lane / FILL_CANDIDATES; b < block_count(); b += chunks) {
        sum = saturating_add(sum, block_counts[b * FILL_CANDIDATES + candidate]);
    }
    lanes[lane] = sum;
    workgroupBarrier();
    if lane != 0u {
        return;
    }
    let is_first = fill.pass_number == 0u;
    let high_before = fill.high_bits;
    var low = fill.low_bits;
    var high = high_before;
    var low_count = fill.low_count;
    var high_count = fill.high_count;
    var goal = fill.goal;
    let least = config.budget - min(config.slack, config.budget);
    var stays = is_found();
    for (var c = 0u; c < FILL_CANDIDATES; c++) {
        var count = 0u;
        for (var chunk = 0u; chunk < chunks; chunk++) {
            count = saturating_add(count, lanes[chunk * FILL_CANDIDATES + c]);
        }
        if is_first && c == FILL_CANDIDATES - 1u {
            // Of pixels it makes no sense.
            let has_plain = config.weight != WEIGHT_ERROR && config.budget_in != BUDGET_TRIANGLES;
            sums.wanted_count = select(0u, count, has_plain);
            break;
        }
        let bits = fill.candidates[c];
        if is_first && c == 0u && has_before() {
            // Of the first pass, so that it was not found before.
            stays = count >= least && count <= config.budget;
            // A little beyond the edge: there it may stay in the next frame, though levels come to something else than the search thought.
            let beyond = (config.budget - least) / 8u;
            goal = select(config.budget - beyond, least + beyond, count < least);
            if stays {
                goal = config.budget;
                low = bits;
                high = bits;
                low_count = count;
                high_count = count;
            }
        }
        if stays {
            // Nothing is left to search between equal heights.
            continue;
        }
        if count <= goal {
            if bits >= low {
                low = bits;
                low_count = count;
            }
        } else if bits < high {
            high = bits;
            high_count = count;
        }
    }
    high = max(high, low);
    fill.goal = goal;
    fill.low_bits = low;
    fill.high_bits = high;
    fill.low_count = low_count;
    fill.high_count = high_count;
    let left = f32(max(goal, low_count) - low_count);
    let part = min(left / f32(max(max(high_count, low_count) - low_count, 1u)), 1.0);
    fill.smooth_bits = low + u32(f32(high - low) * part);
    sums.water_bits = low;
    fill.pass_number++;
    let step = max((high - low) / (FILL_CANDIDATES + 1u), 1u);
    for (var c = 0u; c < FILL_CANDIDATES; c++) {
        fill.candidates[c] = min(low + step * (c + 1u), high);
    }
}

// How much more of the budget the instance takes in the higher water.
fn step_of(i: u32) -> u32 {
    if i >= config.instance_count || culled[i].visible == 0u {
        return 0u;
    }
    let one = weighed(i);
    let low = spent_in(one, fill.low_bits);
    return max(spent_in(one, fill.high_bits), low) - low;
}

@compute @workgroup_size(BLOCK_SIZE)
fn sum_steps(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    lanes[lane] = step_of(block * BLOCK_SIZE + lane);
    for (var half = BLOCK_SIZE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            lanes[lane] = saturating_add(lanes[lane], lanes[lane + half]);
        }
    }
    if lane == 0u && block < block_count() {
        block_counts[block] = lanes[0];
    }
}

// One group: each thread takes a run of blocks. Replaces each block's step by the sum of all before it.
@compute @workgroup_size(BLOCK_SIZE)
fn scan_steps(@builtin(local_invocation_index) lane: u32) {
    let run = (block_count() + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let first = min(lane * run, block_count());
    let end = min(first + run, block_count());
    var total = 0u;
    for (var b = first; b < end; b++) {
        total = saturating_add(total, block_counts[b]);
    }
    lanes[lane] = total;
    scan_group(lane);
    var base = sum_before(lane);
    for (var b = first; b < end; b++) {
        let step = block_counts[b];
        block_counts[b] = base;
        base = saturating_add(base, step);
    }
}

@compute @workgroup_size(BLOCK_SIZE)
fn choose_levels(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * BLOCK_SIZE + lane;
    lanes[lane] = step_of(i);
    scan_group(lane);
    if i >= config.instance_count {
        return;
    }
    if culled[i].visible == 0u {
        choices[i] = LodChoice(0u, 0u);
        return;
    }
    var bits = fill.low_bits;
    let left = max(fill.goal, fill.low_count) - fill.low_count;
    if saturating_add(block_counts[block], sum_up_to(lane)) <= left {
        bits = fill.high_bits;
    }
    let one = weighed(i);
    choices[i] = LodChoice(count_in(one, bits, 0u), count_in(one, bits, 1u));
}
