// The palette of each drawn instance, its joints' matrices between its two frames: once a joint instead of once a vertex.
// Twin: crowd-stages/src/cpu/blend_palettes.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> sorted_keys: array<u32>;
@group(0) @binding(3) var<storage, read> drawn: array<DrawnInstance>;
@group(0) @binding(4) var animation: texture_2d_array<u32>;
@group(0) @binding(5) var<storage, read_write> palettes: array<vec4f>;

@compute @workgroup_size(BLOCK_SIZE)
fn blend_palettes(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let joints = bucket_counts.palette_rows / 3u;
    let place = group_number(workgroup) * BLOCK_SIZE + lane;
    let entry = place / joints;
    if entry >= config.instance_count || sorted_keys[entry] >= bucket_counts.bucket_count {
        return;
    }
    let one = drawn[entry];
    let joint = place - entry * joints;
    if joint * 3u >= one.row_count {
        return;
    }
    let rows = blended_joint(one, joint);
    let at = one.palette_row + joint * 3u;
    palettes[at] = rows[0];
    palettes[at + 1u] = rows[1];
    palettes[at + 2u] = rows[2];
}
