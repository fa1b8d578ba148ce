// The palette of each drawn instance that has room for one, its joints' matrices between its two frames: once a joint instead of once a vertex.
// Twin: crowd-stages/src/cpu/blend_palettes.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> sorted_keys: array<u32>;
@group(0) @binding(3) var<storage, read> drawn: array<DrawnInstance>;
@group(0) @binding(4) var animation: texture_2d_array<u32>;
@group(0) @binding(5) var<storage, read_write> palettes: array<vec4f>;
// Where poses are shared: the entry of each leader, and how many lead; else anything.
@group(0) @binding(6) var<storage, read> leaders: array<u32>;
@group(0) @binding(7) var<storage, read> leader_end: InstanceBase;

fn blend(entry: u32, joint: u32) {
    if entry >= config.instance_count || sorted_keys[entry] >= bucket_counts.bucket_count {
        return;
    }
    let one = drawn[entry];
    if joint * 3u >= one.row_count {
        return;
    }
    let rows = blended_joint(one, joint);
    let at = one.palette_row + joint * 3u;
    palettes[at] = rows[0];
    palettes[at + 1u] = rows[1];
    palettes[at + 2u] = rows[2];
}

// A slot an entry.
@compute @workgroup_size(BLOCK_SIZE)
fn blend_palettes(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let joints = bucket_counts.palette_rows / 3u;
    let place = group_number(workgroup) * BLOCK_SIZE + lane;
    let slot = place / joints;
    if slot < bucket_counts.palette_slots {
        blend(slot, place - slot * joints);
    }
}

// A slot a leader.
@compute @workgroup_size(BLOCK_SIZE)
fn blend_leaders(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let joints = bucket_counts.palette_rows / 3u;
    let place = group_number(workgroup) * BLOCK_SIZE + lane;
    let slot = place / joints;
    if slot < min(leader_end.vertex_base, bucket_counts.palette_slots) {
        blend(leaders[slot], place - slot * joints);
    }
}
