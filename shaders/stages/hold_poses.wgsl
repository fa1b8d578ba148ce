// How long ago each instance's pose is of: far ones keep theirs for a while (ERATO §4). Twin: crowd-stages/src/cpu/hold_poses.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(2) var<storage, read> clip_speeds: array<f32>;
@group(0) @binding(3) var<storage, read_write> instances: array<InstanceRecord>;

@compute @workgroup_size(BLOCK_SIZE)
fn hold_poses(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let instance = instances[i];
    let clip = clips[instance.clip];
    let sphere = world_sphere(instance, clip, clips[leaving_clip(instance)]);
    let ticks = hold_ticks(instance, clip, clip_speeds[instance.clip], sphere);
    var held_s = 0.0;
    if ticks > 0u {
        held_s = clip_seconds(instance, clip) - f32(held_tick(instance, clip, ticks)) * HOLD_TICK_S;
    }
    instances[i].held_s = held_s;
}
