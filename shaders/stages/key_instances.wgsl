// The bucket each instance is drawn from. Twin: crowd-stages/src/cpu/key_instances.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> bucket_counts: BucketCounts;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> bucket_sets: array<BucketSet>;
@group(0) @binding(4) var<storage, read> buckets: array<BucketRecord>;
@group(0) @binding(5) var<storage, read> culled: array<CullRecord>;
@group(0) @binding(6) var<storage, read> choices: array<LodChoice>;
@group(0) @binding(7) var<storage, read> fill: FillState;
@group(0) @binding(8) var<storage, read_write> keys: array<u32>;
@group(0) @binding(9) var<storage, read_write> morphs: array<MorphRecord>;

// How far the water is from this level to the next finer one; full detail has as far to go as it came.
fn fraction_of(levels: BucketSet, level: u32, weight: f32) -> f32 {
    let bucket = buckets[bucket_of_level(levels, level)];
    var finer = 2u * bucket.vertex_count - bucket.coarser_vertex_count;
    if level + 1u < levels.level_count {
        finer = buckets[bucket_of_level(levels, level + 1u)].vertex_count;
    }
    let above = weight * bitcast<f32>(fill.smooth_bits) - f32(bucket.vertex_count);
    return clamp(above / f32(max(finer - bucket.vertex_count, 1u)), 0.0, 1.0);
}

// The share of its pixels that an impostor has on the way from the mesh.
fn impostor_share(area_px2: f32) -> f32 {
    let whole = config.impostor_area_px2;
    return clamp((IMPOSTOR_FADE * whole - area_px2) / ((IMPOSTOR_FADE - 1.0) * whole), 0.0, 1.0);
}

// The finest level of at most that many vertices, by bisection.
@compute @workgroup_size(BLOCK_SIZE)
fn key_levels(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let count = choices[i].vertex_count;
    if count == 0u {
        keys[i] = bucket_counts.bucket_count;
        morphs[i] = MorphRecord(0u, 0.0);
        return;
    }
    let number = instances[i].character;
    let levels = bucket_sets[number];
    let coarsest = buckets[bucket_of_level(levels, 0u)].vertex_count;
    let area_px2 = culled[i].area_px2;
    if count != DOT_VERTICES && stands_in(coarsest, area_px2, config.impostor_area_px2) {
        let fades = count > IMPOSTOR_VERTICES;
        keys[i] = select(bucket_counts.first_impostor, bucket_counts.first_fade, fades) + number;
        morphs[i] = MorphRecord(0u, select(1.0, impostor_share(area_px2), fades));
        return;
    }
    if count < coarsest && count >= DOT_VERTICES {
        keys[i] = bucket_counts.mesh_count + number * DOT_LEVELS + firstLeadingBit(count / DOT_VERTICES);
        morphs[i] = MorphRecord(0u, 1.0);
        return;
    }
    let level = level_of(levels, count);
    let key = bucket_of_level(levels, level);
    keys[i] = key;
    var fraction = 1.0;
    if config.morph == 1u {
        fraction = fraction_of(levels, level, culled[i].weight);
    }
    morphs[i] = MorphRecord(buckets[key].coarser_vertex_count, fraction);
}

@compute @workgroup_size(BLOCK_SIZE)
fn key_full_detail(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    if culled[i].visible == 0u {
        keys[i] = bucket_counts.bucket_count;
        return;
    }
    let levels = bucket_sets[instances[i].character];
    keys[i] = bucket_of_level(levels, levels.level_count - 1u);
}
