// The bucket each instance is drawn from and, behind it, the pose it is in: equal keys look the same. Twin:
// crowd-stages/src/cpu/key_poses.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> pose_counts: PoseCounts;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(4) var<storage, read> clip_speeds: array<f32>;
@group(0) @binding(5) var<storage, read> first_poses: array<u32>;
@group(0) @binding(6) var<storage, read> keys: array<u32>;
@group(0) @binding(7) var<storage, read_write> morphs: array<MorphRecord>;
@group(0) @binding(8) var<storage, read_write> pose_keys: array<u32>;

@compute @workgroup_size(BLOCK_SIZE)
fn key_poses(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let instance = instances[i];
    let clip = clips[instance.clip];
    let sphere = world_sphere(instance, clip, clips[leaving_clip(instance)]);
    let ticks = hold_ticks(instance, clip, clip_speeds[instance.clip], sphere);
    let is_still = instance.leaving_share == 0.0 && (clip.duration_s <= 0.0 || clip.frame_count < 2u);
    var pose = pose_counts.own_pose;
    if keys[i] < pose_counts.mesh_count && (ticks > 0u || is_still) {
        var tick = 0u;
        if !is_still {
            tick = min(held_tick(instance, clip, ticks), clip_ticks(clip) - 1u);
        }
        // Quarters of a morph: as many as share a pose are as far between two levels.
        let quarters = u32(morphs[i].fraction * 4.0 + 0.5);
        morphs[i].fraction = f32(quarters) * 0.25;
        pose = (first_poses[instance.clip] + tick) * 5u + min(quarters, 4u);
    }
    pose_keys[i] = keys[i] << pose_counts.pose_bits | pose;
}
