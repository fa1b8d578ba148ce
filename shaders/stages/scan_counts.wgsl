// Exclusive prefix sums of vertex and triangle counts over all instances (Dong 2019 §5.3), saturating:
// sums of blocks, one group scans the blocks, then each block scans itself. Twin: crowd-stages/src/cpu/scan_counts.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> choices: array<LodChoice>;
@group(0) @binding(2) var<storage, read_write> block_totals: array<InstanceBase>;
@group(0) @binding(3) var<storage, read_write> bases: array<InstanceBase>;
@group(0) @binding(4) var<storage, read_write> totals: InstanceBase;

var<workgroup> ends: array<vec2u, BLOCK_SIZE>;

fn add(a: vec2u, b: vec2u) -> vec2u {
    return vec2u(saturating_add(a.x, b.x), saturating_add(a.y, b.y));
}

// Inclusive scan of `ends` over the group.
fn scan_group(lane: u32) {
    for (var step = 1u; step < BLOCK_SIZE; step *= 2u) {
        workgroupBarrier();
        var value = ends[lane];
        if lane >= step {
            value = add(value, ends[lane - step]);
        }
        workgroupBarrier();
        ends[lane] = value;
    }
    workgroupBarrier();
}

fn count_of(i: u32) -> vec2u {
    if i >= config.instance_count {
        return vec2u(0u);
    }
    return vec2u(choices[i].vertex_count, choices[i].triangle_count);
}

@compute @workgroup_size(BLOCK_SIZE)
fn sum_blocks(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    ends[lane] = count_of(block * BLOCK_SIZE + lane);
    scan_group(lane);
    if lane == BLOCK_SIZE - 1u && block * BLOCK_SIZE < config.instance_count {
        block_totals[block] = InstanceBase(ends[lane].x, ends[lane].y);
    }
}

// One group: each thread takes a run of blocks. Replaces each block's total by the sum of all before it.
@compute @workgroup_size(BLOCK_SIZE)
fn scan_blocks(@builtin(local_invocation_index) lane: u32) {
    let block_count = (config.instance_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let run = (block_count + BLOCK_SIZE - 1u) / BLOCK_SIZE;
    let first = lane * run;
    let end = min((lane + 1u) * run, block_count);
    var total = vec2u(0u);
    for (var b = first; b < end; b++) {
        total = add(total, vec2u(block_totals[b].vertex_base, block_totals[b].triangle_base));
    }
    ends[lane] = total;
    scan_group(lane);
    if lane == BLOCK_SIZE - 1u {
        totals = InstanceBase(ends[lane].x, ends[lane].y);
    }
    var base = vec2u(0u);
    if lane > 0u {
        base = ends[lane - 1u];
    }
    for (var b = first; b < end; b++) {
        let count = vec2u(block_totals[b].vertex_base, block_totals[b].triangle_base);
        block_totals[b] = InstanceBase(base.x, base.y);
        base = add(base, count);
    }
}

@compute @workgroup_size(BLOCK_SIZE)
fn write_bases(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let block = group_number(workgroup);
    let i = block * BLOCK_SIZE + lane;
    ends[lane] = count_of(i);
    scan_group(lane);
    if i >= config.instance_count {
        return;
    }
    var before = vec2u(0u);
    if lane > 0u {
        before = ends[lane - 1u];
    }
    let base = add(vec2u(block_totals[block].vertex_base, block_totals[block].triangle_base), before);
    bases[i] = InstanceBase(base.x, base.y);
}
