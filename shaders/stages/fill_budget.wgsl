// Water filling: the highest level of water (vertices a unit of weight; they or their triangles count) at which the crowd fits the budget;
// what is left goes to the first instances as a step towards the next height.
// The twin looks at sixteen heights in each of three passes. All heights that it may come to are cells here, numbered as they rise. What the crowd takes
// never falls as the water rises (no table of levels falls, but for one that is crafted to), so any search for the last cell that fits finds the same one: this
// begins where the water was before.
// Integers and single products only, so the twin is equal. Twin: crowd-stages/src/cpu/fill_budget.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> characters: array<CharacterRecord>;
// LodRecords as words, so that the one that counts is fetched by its number.
@group(0) @binding(2) var<storage, read> lods: array<u32>;
@group(0) @binding(3) var<storage, read> culled: array<CullRecord>;
// The steps of all chunks before each, and of all; then, of each round's heights one after another, what each chunk takes.
@group(0) @binding(4) var<storage, read_write> block_counts: array<u32>;
@group(0) @binding(5) var<storage, read_write> fill: FillState;
@group(0) @binding(6) var<storage, read_write> sums: WeightSums;
@group(0) @binding(7) var<storage, read_write> choices: array<LodChoice>;

// Nobody is an impostor, and levels are not by error: what most frames are. A branch would cost what it leaves out, on adapters that go through both sides.
override IS_PLAIN: bool = false;
// Below so many vertices every character is dots, the same for all: their number is worked out and no table asked. Twin: dot_reach in crowd-stages/src/dots.rs.
override DOT_REACH: f32 = 0.0;

// Threads of a group that sums a chunk of instances.
const FILL_GROUP_SIZE: u32 = 64u;
// Most instances of whom a thread notes who needs a second look: the bits of a word.
const NOTED: u32 = 32u;
// Between two heights of the first pass there are seventeen parts, with seventeen parts each.
const FILL_PARTS: u32 = FILL_CANDIDATES + 1u;
const FILL_CELLS: u32 = FILL_PARTS * FILL_PARTS;
// The highest one, at the last height of the first pass.
const LAST_CELL: u32 = (FILL_CANDIDATES - 1u) * FILL_CELLS;
// Where among the heights tried first those of Eq. 1, of no water, and of the water before are.
const PLAIN_SLOT: u32 = 0u;
const EMPTY_SLOT: u32 = 1u;
const BEFORE_SLOT: u32 = 2u;
// Bits of 2^80: far above what fills any level, and no product with a weight overflows.
const HIGHEST_BITS: u32 = 0x67800000u;

var<workgroup> lane_counts: array<u32, 512>;
var<workgroup> edge: u32;

// Blocks of 256 that one group sums: fewer sums of groups to add, and groups with nothing to do cost little.
fn blocks_a_chunk() -> u32 {
    return max((config.instance_count + BLOCK_SIZE * FILL_CHUNKS - 1u) / (BLOCK_SIZE * FILL_CHUNKS), 1u);
}

fn chunk_size() -> u32 {
    return blocks_a_chunk() * BLOCK_SIZE;
}

fn chunk_count() -> u32 {
    return (config.instance_count + chunk_size() - 1u) / chunk_size();
}

// Of what a chunk takes at a height, counted through all rounds.
fn count_at(slot: u32, chunk: u32) -> u32 {
    return (slot + 1u) * chunk_count() + 1u + chunk;
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

// The lower end of a part between two heights, and the upper.
fn part_of(ends: vec2u, number: u32) -> vec2u {
    let step = max((ends.y - ends.x) / FILL_PARTS, 1u);
    let low = min(ends.x + step * number, ends.y);
    return vec2u(low, select(min(low + step, ends.y), ends.y, number + 1u == FILL_PARTS));
}

// The height at which a cell begins.
fn cell_bits(cell: u32) -> u32 {
    let first = min(cell, LAST_CELL) / FILL_CELLS;
    let inner = min(cell, LAST_CELL) % FILL_CELLS;
    let ends = vec2u(fill.candidates[first], fill.candidates[min(first + 1u, FILL_CANDIDATES - 1u)]);
    return part_of(part_of(ends, inner / FILL_PARTS), inner % FILL_PARTS).x;
}

// The cell that such a height is in.
fn cell_of(bits: u32) -> u32 {
    var first = 0u;
    while first + 1u < FILL_CANDIDATES && fill.candidates[first + 1u] <= bits {
        first++;
    }
    if first + 1u == FILL_CANDIDATES {
        return LAST_CELL;
    }
    var cell = first;
    var ends = vec2u(fill.candidates[first], fill.candidates[first + 1u]);
    for (var pass_number = 0u; pass_number < 2u; pass_number++) {
        let step = max((ends.y - ends.x) / FILL_PARTS, 1u);
        let number = min((bits - ends.x) / step, FILL_PARTS - 1u);
        ends = part_of(ends, number);
        cell = cell * FILL_PARTS + number;
    }
    return cell;
}

// Tries a cell in the next round; cell 0, whose count is known, and cells beyond the last are none.
fn try_cell(slot: u32, cell: u32) {
    fill.cells[slot] = select(NONE, cell, cell > fill.low_cell && cell < fill.high_cell);
    fill.heights[slot] = cell_bits(cell);
}

// The heights of the first pass: none, powers of two around Eq. 1's, the highest. Where the water may stay, its height before is in the place of the
// lowest power. The first round looks around where the water was, or at Eq. 1's height where there was none.
@compute @workgroup_size(1)
fn begin() {
    let around = exponent_of(f32(config.budget)) - exponent_of(sums.weight);
    var plain = 0u;
    if sums.weight > 0.0 {
        plain = bitcast<u32>(clamp(f32(config.budget) / sums.weight, 0.0, bitcast<f32>(HIGHEST_BITS)));
    }
    var hint = select(plain, fill.low_bits, fill.low_bits > 0u);
    fill.low_bits = 0u;
    fill.high_bits = HIGHEST_BITS;
    fill.low_count = sums.min_vertex_count;
    fill.high_count = 0xffffffffu;
    fill.pass_number = 0u;
    fill.goal = config.budget;
    fill.low_cell = 0u;
    fill.high_cell = LAST_CELL + 1u;
    fill.low_slot = EMPTY_SLOT;
    fill.high_slot = EMPTY_SLOT;
    fill.candidates[0] = 0u;
    for (var c = 1u; c < FILL_CANDIDATES - 1u; c++) {
        fill.candidates[c] = power_bits(around + i32(c) - 7);
    }
    fill.candidates[FILL_CANDIDATES - 1u] = HIGHEST_BITS;
    var before = 1u;
    if has_before() {
        hint = min(config.water_before_bits, HIGHEST_BITS);
        while before + 1u < FILL_CANDIDATES && fill.candidates[before + 1u] < hint {
            fill.candidates[before] = fill.candidates[before + 1u];
            before++;
        }
        fill.candidates[before] = hint;
    }
    var cell = max(cell_of(hint), 1u);
    // Nothing fits but the coarsest levels, or not even those: the lowest height says so at once.
    if sums.min_vertex_count >= config.budget {
        cell = 1u;
    }
    try_cell(BEFORE_SLOT, select(max(cell, 65u) - 64u, before * FILL_CELLS, has_before()));
    try_cell(3u, max(cell, 9u) - 8u);
    try_cell(4u, cell);
    try_cell(5u, cell + 1u);
    try_cell(6u, cell + 9u);
    try_cell(7u, cell + 65u);
    fill.cells[PLAIN_SLOT] = NONE;
    fill.heights[PLAIN_SLOT] = plain;
    fill.cells[EMPTY_SLOT] = NONE;
    fill.heights[EMPTY_SLOT] = 0u;
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

// Of one that is seen.
fn weighed(i: u32) -> Weighed {
    let number = culled[i].visible - 1u;
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
    if IS_PLAIN {
        return lods[2u * (one.first_entry + u32(k)) + in_triangles];
    }
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

fn heights_from(first: u32) -> vec4u {
    return vec4u(fill.heights[first], fill.heights[first + 1u], fill.heights[first + 2u], fill.heights[first + 3u]);
}

fn keep_lane_counts(first: u32, counts: vec4u) {
    for (var c = 0u; c < 4u; c++) {
        lane_counts[first + c] = counts[c];
    }
}

// Whether nothing is left to search.
fn is_found() -> bool {
    return fill.high_cell <= fill.low_cell + 1u && fill.pass_number > 0u;
}

// What the threads of a group have counted at the eight heights, added up for its chunk.
fn sum_lanes(chunk: u32, lane: u32, counts_a: vec4u, counts_b: vec4u) {
    keep_lane_counts(lane * FILL_TRIED, counts_a);
    keep_lane_counts(lane * FILL_TRIED + 4u, counts_b);
    workgroupBarrier();
    if lane < FILL_TRIED && chunk < chunk_count() && !is_found() {
        var sum = 0u;
        for (var l = 0u; l < FILL_GROUP_SIZE; l++) {
            sum = saturating_add(sum, lane_counts[l * FILL_TRIED + lane]);
        }
        block_counts[count_at(fill.pass_number * FILL_TRIED + lane, chunk)] = sum;
    }
}

// The eight sums are two vectors, which stay in registers; an array would not.
@compute @workgroup_size(FILL_GROUP_SIZE)
fn sum_heights(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let chunk = group_number(workgroup);
    let bits_a = heights_from(0u);
    let bits_b = heights_from(4u);
    var counts_a = vec4u();
    var counts_b = vec4u();
    // Nobody is looked at once it is found.
    let first = min(chunk * chunk_size(), config.instance_count);
    let end = select(min(first + chunk_size(), config.instance_count), 0u, is_found());
    for (var i = first + lane; i < end; i += FILL_GROUP_SIZE) {
        if culled[i].visible == 0u {
            continue;
        }
        let one = weighed(i);
        counts_a = saturating_add_4(counts_a, counts_in(one, bits_a));
        counts_b = saturating_add_4(counts_b, counts_in(one, bits_b));
    }
    sum_lanes(chunk, lane, counts_a, counts_b);
}

// Whether the number of its vertices is worked out so at a product up to this.
fn is_dots(one: CullRecord, product: f32) -> bool {
    return (one.area_px2 < config.dot_area_px2) & (product < DOT_REACH);
}

// The same as `sum_heights` where many are dots, for adapters that are processors: first those, whose records alone are read, then the others, whom each
// thread has noted. A loop ends there for a group of lanes when it does for all of them; an `if` saves nothing.
@compute @workgroup_size(FILL_GROUP_SIZE)
fn sum_heights_of_dots(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let chunk = group_number(workgroup);
    let bits_a = heights_from(0u);
    let bits_b = heights_from(4u);
    let most = max(bits_a, bits_b);
    let highest = bitcast<f32>(max(max(most.x, most.y), max(most.z, most.w)));
    var counts_a = vec4u();
    var counts_b = vec4u();
    let first = min(chunk * chunk_size(), config.instance_count);
    let end = select(min(first + chunk_size(), config.instance_count), 0u, is_found());
    for (var batch = first + lane; batch < end; batch += NOTED * FILL_GROUP_SIZE) {
        var others = 0u;
        var dots_a = vec4u();
        var dots_b = vec4u();
        let turns = min((end - batch + FILL_GROUP_SIZE - 1u) / FILL_GROUP_SIZE, NOTED);
        for (var turn = 0u; turn < turns; turn++) {
            let one = culled[batch + turn * FILL_GROUP_SIZE];
            let is_far = is_dots(one, one.weight * highest);
            let seen = select(0u, 1u, one.visible != 0u);
            others |= select(seen, 0u, is_far) << turn;
            let counted = vec4u(select(0u, seen, is_far));
            dots_a += counted * dots_at(one.weight * bitcast<vec4f>(bits_a));
            dots_b += counted * dots_at(one.weight * bitcast<vec4f>(bits_b));
        }
        let each = select(DOT_VERTICES, 1u, config.budget_in == BUDGET_TRIANGLES);
        counts_a = saturating_add_4(counts_a, each * dots_a);
        counts_b = saturating_add_4(counts_b, each * dots_b);
        while others != 0u {
            let one = weighed(batch + firstTrailingBit(others) * FILL_GROUP_SIZE);
            others &= others - 1u;
            counts_a = saturating_add_4(counts_a, counts_in(one, bits_a));
            counts_b = saturating_add_4(counts_b, counts_in(one, bits_b));
        }
    }
    sum_lanes(chunk, lane, counts_a, counts_b);
}

// Sum of a slot, of `lanes`.
fn slot_count(slot: u32) -> u32 {
    var count = 0u;
    for (var part = 0u; part < BLOCK_SIZE / FILL_TRIED; part++) {
        count = saturating_add(count, lanes[part * FILL_TRIED + slot]);
    }
    return count;
}

// One group: threads s, s + 8, ... add the chunks' sums of slot s. Then between which two heights the budget lies.
@compute @workgroup_size(BLOCK_SIZE)
fn narrow(@builtin(local_invocation_index) lane: u32) {
    let slots = fill.pass_number * FILL_TRIED;
    var sum = 0u;
    let end = select(chunk_count(), 0u, is_found());
    for (var chunk = lane / FILL_TRIED; chunk < end; chunk += BLOCK_SIZE / FILL_TRIED) {
        sum = saturating_add(sum, block_counts[count_at(slots + lane % FILL_TRIED, chunk)]);
    }
    lanes[lane] = sum;
    workgroupBarrier();
    if lane != 0u || is_found() {
        return;
    }
    let is_first = fill.pass_number == 0u;
    if is_first {
        // Of pixels it makes no sense.
        let has_plain = config.weight != WEIGHT_ERROR && config.budget_in != BUDGET_TRIANGLES;
        sums.wanted_count = select(0u, slot_count(PLAIN_SLOT), has_plain);
    }
    var stays = false;
    if is_first && has_before() {
        let count = slot_count(BEFORE_SLOT);
        let least = config.budget - min(config.slack, config.budget);
        // A little beyond the edge: there it may stay in the next frame, though levels come to something else than the search thought.
        let beyond = (config.budget - least) / 8u;
        stays = count >= least && count <= config.budget;
        if stays {
            fill.low_cell = fill.cells[BEFORE_SLOT];
            fill.high_cell = fill.low_cell;
            fill.low_slot = BEFORE_SLOT;
            fill.high_slot = BEFORE_SLOT;
            fill.low_count = count;
            fill.high_count = count;
        } else {
            fill.goal = select(config.budget - beyond, least + beyond, count < least);
        }
    }
    for (var slot = 0u; slot < FILL_TRIED && !stays; slot++) {
        let cell = fill.cells[slot];
        if cell == NONE {
            continue;
        }
        let count = slot_count(slot);
        if count <= fill.goal {
            if cell > fill.low_cell {
                fill.low_cell = cell;
                fill.low_count = count;
                fill.low_slot = slots + slot;
            }
        } else if cell < fill.high_cell {
            fill.high_cell = cell;
            fill.high_count = count;
            fill.high_slot = slots + slot;
        }
    }
    // Where a table of levels falls, a height that fits may lie above one that does not: there is nothing between them to look for.
    if fill.high_cell < fill.low_cell {
        fill.high_cell = fill.low_cell;
        fill.high_count = fill.low_count;
        fill.high_slot = fill.low_slot;
    }
    if fill.high_cell > LAST_CELL && fill.low_cell == LAST_CELL {
        fill.high_slot = fill.low_slot;
    }
    let low = cell_bits(fill.low_cell);
    let high = cell_bits(fill.high_cell);
    fill.low_bits = low;
    fill.high_bits = high;
    let left = f32(max(fill.goal, fill.low_count) - fill.low_count);
    let part = left / f32(max(max(fill.high_count, fill.low_count) - fill.low_count, 1u));
    fill.smooth_bits = low + u32(f32(high - low) * min(part, 1.0));
    sums.water_bits = low;
    fill.pass_number++;
    choose_heights(part);
}

// The heights of the next round. `part`: how far the goal is from the count at the lower end to that at the upper.
// Near the end all eight are neighbours about where it should be; ninths of what is left find it in four rounds at most where that fails, see `FILL_ROUNDS`.
fn choose_heights(part: f32) {
    let low = fill.low_cell;
    let cells = fill.high_cell - low;
    let guess = low + u32(f32(cells) * min(part, 1.0));
    let is_near = cells <= FILL_TRIED + 1u;
    let is_guessed = fill.pass_number == 1u && cells <= 131u && fill.high_count != 0xffffffffu;
    let highest = max(fill.high_cell, low + FILL_TRIED + 1u) - FILL_TRIED;
    let first = select(clamp(max(guess, 3u) - 3u, low + 1u, highest), low + 1u, is_near);
    for (var slot = 0u; slot < FILL_TRIED; slot++) {
        let ninth = low + cells * (slot + 1u) / (FILL_TRIED + 1u);
        try_cell(slot, select(ninth, first + slot, is_near || is_guessed));
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

// What is left of the budget for steps.
fn left_over() -> u32 {
    return max(fill.goal, fill.low_count) - fill.low_count;
}

@compute @workgroup_size(BLOCK_SIZE)
fn sum_steps(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let chunk = group_number(workgroup);
    var sum = 0u;
    for (var block = 0u; block < blocks_a_chunk(); block++) {
        sum = saturating_add(sum, step_of(chunk * chunk_size() + block * BLOCK_SIZE + lane));
    }
    lanes[lane] = sum;
    for (var half = BLOCK_SIZE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            lanes[lane] = saturating_add(lanes[lane], lanes[lane + half]);
        }
    }
    if lane == 0u && chunk < chunk_count() {
        block_counts[chunk] = lanes[0];
    }
}

// A chunk's step: as it was summed, or from what the search has counted at both heights.
fn step_of_chunk(chunk: u32, is_searched: bool) -> u32 {
    if !is_searched {
        return block_counts[chunk];
    }
    let low = block_counts[count_at(fill.low_slot, chunk)];
    return max(block_counts[count_at(fill.high_slot, chunk)], low) - low;
}

// One group: each thread takes a run of chunks. Each chunk gets the sum of all before it, and the one in which the budget runs out is remembered.
fn scan_chunks(lane: u32, is_searched: bool) {
    let run = (chunk_count() + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let first = min(lane * run, chunk_count());
    let end = min(first + run, chunk_count());
    var total = 0u;
    for (var chunk = first; chunk < end; chunk++) {
        total = saturating_add(total, step_of_chunk(chunk, is_searched));
    }
    lanes[lane] = total;
    if lane == 0u {
        edge = NONE;
    }
    scan_group(lane);
    let left = left_over();
    var base = sum_before(lane);
    for (var chunk = first; chunk < end; chunk++) {
        let after = saturating_add(base, step_of_chunk(chunk, is_searched));
        if base <= left && after > left {
            edge = chunk;
        }
        block_counts[chunk] = base;
        if chunk + 1u == chunk_count() {
            block_counts[chunk + 1u] = after;
        }
        base = after;
    }
    workgroupBarrier();
    if lane == 0u {
        fill.edge = edge;
    }
}

@compute @workgroup_size(BLOCK_SIZE)
fn scan_steps(@builtin(local_invocation_index) lane: u32) {
    scan_chunks(lane, false);
}

@compute @workgroup_size(BLOCK_SIZE)
fn scan_counts(@builtin(local_invocation_index) lane: u32) {
    scan_chunks(lane, true);
}

fn choice_of(i: u32, takes_step: bool) -> LodChoice {
    let one = weighed(i);
    let bits = select(fill.low_bits, fill.high_bits, takes_step);
    return LodChoice(count_in(one, bits, 0u), count_in(one, bits, 1u));
}

// Chunks whose steps all fit take them. Those of the one in which the budget runs out come next.
@compute @workgroup_size(BLOCK_SIZE)
fn choose_levels(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    if culled[i].visible == 0u {
        choices[i] = LodChoice(0u, 0u);
        return;
    }
    choices[i] = choice_of(i, block_counts[i / chunk_size() + 1u] <= left_over());
}

// The same where many are dots, as `sum_heights_of_dots` is. A group a chunk.
@compute @workgroup_size(FILL_GROUP_SIZE)
fn choose_levels_of_dots(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let chunk = group_number(workgroup);
    let takes_step = block_counts[min(chunk, FILL_CHUNKS) + 1u] <= left_over();
    let height = bitcast<f32>(select(fill.low_bits, fill.high_bits, takes_step));
    let first = min(chunk * chunk_size(), config.instance_count);
    let end = min(first + chunk_size(), config.instance_count);
    for (var batch = first + lane; batch < end; batch += NOTED * FILL_GROUP_SIZE) {
        var others = 0u;
        let turns = min((end - batch + FILL_GROUP_SIZE - 1u) / FILL_GROUP_SIZE, NOTED);
        for (var turn = 0u; turn < turns; turn++) {
            let i = batch + turn * FILL_GROUP_SIZE;
            let one = culled[i];
            let product = one.weight * height;
            let seen = select(0u, 1u, one.visible != 0u);
            let other = select(seen, 0u, is_dots(one, product));
            others |= other << turn;
            if other == 0u {
                let dots = seen * dots_at(vec4f(product)).x;
                choices[i] = LodChoice(DOT_VERTICES * dots, dots);
            }
        }
        while others != 0u {
            let i = batch + firstTrailingBit(others) * FILL_GROUP_SIZE;
            others &= others - 1u;
            choices[i] = choice_of(i, takes_step);
        }
    }
}

// One group: who of that chunk takes the step.
@compute @workgroup_size(BLOCK_SIZE)
fn choose_edge(@builtin(local_invocation_index) lane: u32) {
    let chunk = fill.edge;
    var base = 0u;
    if chunk != NONE {
        base = block_counts[chunk];
    }
    for (var block = 0u; block < blocks_a_chunk(); block++) {
        let i = select(chunk * chunk_size() + block * BLOCK_SIZE + lane, NONE, chunk == NONE);
        lanes[lane] = step_of(i);
        scan_group(lane);
        let taken = saturating_add(base, sum_up_to(lane));
        base = saturating_add(base, sum_up_to(BLOCK_SIZE - 1u));
        if i < config.instance_count && culled[i].visible != 0u {
            choices[i] = choice_of(i, taken <= left_over());
        }
        workgroupBarrier();
    }
}
