// Park & Han 2009 §3.1: an instance is the centre of its box; it is seen when that lies in the frustum widened by half the
// diagonal of the largest box, and its depth in clip space says which of three levels it is drawn at.
// Twin: crowd-stages/src/cpu/cull_by_depth.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<uniform> discrete: DiscreteConfig;
@group(0) @binding(3) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(4) var<storage, read> characters: array<CharacterRecord>;
// Buckets of a character's three levels, the finest first.
@group(0) @binding(5) var<storage, read> discrete_buckets: array<u32>;
@group(0) @binding(6) var<storage, read_write> keys: array<u32>;

@compute @workgroup_size(BLOCK_SIZE)
fn cull_by_depth(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let instance = instances[i];
    let character = characters[instance.character];
    let center = world_from_local(instance, (character.box_min + character.box_max) * 0.5);
    let reach = discrete.half_diagonal_m * instance.scale;
    var visible = instance.scale != 0.0;
    for (var p = 0u; p < 6u; p++) {
        let plane = config.planes[p];
        visible = visible && dot(plane.xyz, center) + plane.w >= -reach;
    }
    if !visible {
        keys[i] = bucket_counts.bucket_count;
        return;
    }
    let depth_m = (config.clip_from_world * vec4f(center, 1.0)).w;
    let level = select(0u, 1u, depth_m > config.lod_depths_m.x) + select(0u, 1u, depth_m > config.lod_depths_m.y);
    keys[i] = discrete_buckets[instance.character * 3u + level];
}
