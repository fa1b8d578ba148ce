// The first of each run of equal keys leads: its pose is everyone's who has that key. Twin: crowd-stages/src/cpu/find_leaders.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> pose_counts: PoseCounts;
@group(0) @binding(2) var<storage, read> sorted_pose_keys: array<u32>;
@group(0) @binding(3) var<storage, read> sorted_by_pose: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_values: array<u32>;
// A vertex for a leader: its places come from the prefix sums of vertices.
@group(0) @binding(6) var<storage, read_write> leads: array<LodChoice>;

@compute @workgroup_size(BLOCK_SIZE)
fn find_leaders(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let entry = group_number(workgroup) * BLOCK_SIZE + lane;
    if entry >= config.instance_count {
        return;
    }
    let key = sorted_pose_keys[entry];
    let bucket = key >> pose_counts.pose_bits;
    let pose = key & ((1u << pose_counts.pose_bits) - 1u);
    let is_new = entry == 0u || sorted_pose_keys[max(entry, 1u) - 1u] != key || pose == pose_counts.own_pose;
    sorted_keys[entry] = bucket;
    sorted_values[entry] = sorted_by_pose[entry];
    leads[entry] = LodChoice(select(0u, 1u, is_new && bucket < pose_counts.bucket_count), 0u);
}
