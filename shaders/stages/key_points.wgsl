// Whether an instance is drawn as points, and as how many: the coarsest density with a point for each pixel of its sphere.
// Twin: crowd-stages/src/cpu/key_points.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> bucket_sets: array<BucketSet>;
@group(0) @binding(4) var<storage, read> buckets: array<BucketRecord>;
@group(0) @binding(5) var<storage, read> culled: array<CullRecord>;
@group(0) @binding(6) var<storage, read_write> keys: array<u32>;

@compute @workgroup_size(BLOCK_SIZE)
fn key_points(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    if culled[i].visible == 0u {
        keys[i] = bucket_counts.bucket_count;
        return;
    }
    let number = instances[i].character;
    let first = bucket_counts.mesh_count + number * POINT_LEVELS;
    for (var bucket = first; bucket < first + POINT_LEVELS; bucket++) {
        let points = buckets[bucket].vertex_count;
        if points > 0u && f32(points) >= culled[i].area_px2 {
            keys[i] = bucket;
            return;
        }
    }
    let levels = bucket_sets[number];
    keys[i] = bucket_of_level(levels, levels.level_count - 1u);
}
