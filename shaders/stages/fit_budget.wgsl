// Shrinks what was wanted until it fits the budget, then looks up the levels. Integers only, so the twin is equal.
// Twin: crowd-stages/src/cpu/fit_budget.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(2) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(3) var<storage, read> lods: array<LodRecord>;
@group(0) @binding(4) var<storage, read> wanted: array<u32>;
@group(0) @binding(5) var<storage, read_write> block_wanted: array<u32>;
@group(0) @binding(6) var<storage, read_write> sums: WeightSums;
@group(0) @binding(7) var<storage, read_write> choices: array<LodChoice>;

var<workgroup> counts: array<u32, BLOCK_SIZE>;

fn reduce_tree(lane: u32) {
    for (var half = BLOCK_SIZE / 2u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            counts[lane] = saturating_add(counts[lane], counts[lane + half]);
        }
    }
    workgroupBarrier();
}

@compute @workgroup_size(BLOCK_SIZE)
fn sum_wanted_blocks(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * BLOCK_SIZE + lane;
    counts[lane] = 0u;
    if i < config.instance_count {
        counts[lane] = wanted[i];
    }
    reduce_tree(lane);
    if lane == 0u && block * BLOCK_SIZE < config.instance_count {
        block_wanted[block] = counts[0];
    }
}

// floor(numerator * 2^32 / denominator) for numerator < denominator, bit by bit.
fn fraction_32(numerator: u32, denominator: u32) -> u32 {
    var remainder = numerator;
    var quotient = 0u;
    for (var bit = 0u; bit < 32u; bit++) {
        let carry = remainder >> 31u;
        remainder = remainder << 1u;
        quotient = quotient << 1u;
        if carry == 1u || remainder >= denominator {
            remainder -= denominator;
            quotient |= 1u;
        }
    }
    return quotient;
}

@compute @workgroup_size(BLOCK_SIZE)
fn find_share(@builtin(local_invocation_index) lane: u32) {
    let block_count = (config.instance_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let run = (block_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    var count = 0u;
    for (var b = lane * run; b < min((lane + 1u) * run, block_count); b++) {
        count = saturating_add(count, block_wanted[b]);
    }
    counts[lane] = count;
    reduce_tree(lane);
    if lane != 0u {
        return;
    }
    let total = counts[0];
    let coarsest = sums.min_vertex_count;
    sums.wanted_count = total;
    sums.share = 0u;
    sums.is_scaled = 0u;
    if total > config.budget {
        sums.is_scaled = 1u;
        if config.budget > coarsest {
            sums.share = fraction_32(config.budget - coarsest, total - coarsest);
        }
    }
}

// The high word of a 32 x 32 bit product.
fn multiply_high(a: u32, b: u32) -> u32 {
    let low = (a & 0xffffu) * (b & 0xffffu);
    let middle_a = (a >> 16u) * (b & 0xffffu) + (low >> 16u);
    let middle_b = (a & 0xffffu) * (b >> 16u) + (middle_a & 0xffffu);
    return (a >> 16u) * (b >> 16u) + (middle_a >> 16u) + (middle_b >> 16u);
}

@compute @workgroup_size(BLOCK_SIZE)
fn choose_levels(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    var k = wanted[i];
    if k == 0u {
        choices[i] = LodChoice(0u, 0u);
        return;
    }
    let character = characters[instances[i].character];
    if sums.is_scaled == 1u {
        let least = character.min_vertex_count;
        k = least + multiply_high(k - least, sums.share);
    }
    let level = lods[character.lod_offset + k];
    choices[i] = LodChoice(level.vertex_count, level.triangle_count);
}
