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

// Below so many vertices every character is dots. Twin: dot_reach in crowd-stages/src/dots.rs.
override DOT_REACH: u32 = 0u;

// Threads of a group that looks at dots first, and instances of each: at most the bits of a word.
const KEY_GROUP_SIZE: u32 = 64u;
const KEY_RUN: u32 = 16u;

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

struct Keyed {
    key: u32,
    morph: MorphRecord,
}

fn dots_key(number: u32, count: u32) -> u32 {
    return bucket_counts.mesh_count + number * DOT_LEVELS + firstLeadingBit(count / DOT_VERTICES);
}

// Of someone with that many vertices: the finest level of at most as many, by bisection.
fn keyed(i: u32, count: u32) -> Keyed {
    let number = instances[i].character;
    let levels = bucket_sets[number];
    let coarsest = buckets[bucket_of_level(levels, 0u)].vertex_count;
    let area_px2 = culled[i].area_px2;
    if count != DOT_VERTICES && stands_in(coarsest, area_px2, config.impostor_area_px2) {
        let fades = count > IMPOSTOR_VERTICES;
        let key = select(bucket_counts.first_impostor, bucket_counts.first_fade, fades) + number;
        return Keyed(key, MorphRecord(0u, select(1.0, impostor_share(area_px2), fades)));
    }
    if count < coarsest && count >= DOT_VERTICES {
        return Keyed(dots_key(number, count), MorphRecord(0u, 1.0));
    }
    let level = level_of(levels, count);
    let key = bucket_of_level(levels, level);
    var fraction = 1.0;
    if config.morph == 1u {
        fraction = fraction_of(levels, level, culled[i].weight);
    }
    return Keyed(key, MorphRecord(buckets[key].coarser_vertex_count, fraction));
}

@compute @workgroup_size(BLOCK_SIZE)
fn key_levels(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let count = choices[i].vertex_count;
    var one = Keyed(bucket_counts.bucket_count, MorphRecord(0u, 0.0));
    if count > 0u {
        one = keyed(i, count);
    }
    keys[i] = one.key;
    morphs[i] = one.morph;
}

// The same for adapters that are processors: first those whom nobody sees or who are dots, then the others, whom each thread has noted. A loop ends there
// for a group of lanes when it does for all of them; an `if` saves nothing.
@compute @workgroup_size(KEY_GROUP_SIZE)
fn key_dots_first(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let first = group_number(workgroup) * KEY_RUN * KEY_GROUP_SIZE + lane;
    // Where there are impostors a few vertices may be one.
    let reach = select(DOT_REACH, 0u, config.impostor_area_px2 > 0.0);
    let left = max(config.instance_count, first) - first;
    let turns = min((left + KEY_GROUP_SIZE - 1u) / KEY_GROUP_SIZE, KEY_RUN);
    var others = 0u;
    for (var turn = 0u; turn < turns; turn++) {
        let i = first + turn * KEY_GROUP_SIZE;
        let count = choices[i].vertex_count;
        // Casters of shadows whom nobody sees are among the others: their characters stand in the instances alone, three times as long.
        let number = culled[i].visible;
        let is_dots = (count >= DOT_VERTICES) & (count < reach) & (number > 0u);
        let is_other = (count > 0u) & !is_dots;
        others |= select(0u, 1u, is_other) << turn;
        if !is_other {
            keys[i] = select(bucket_counts.bucket_count, dots_key(number - 1u, count), is_dots);
            morphs[i] = MorphRecord(0u, select(0.0, 1.0, is_dots));
        }
    }
    while others != 0u {
        let i = first + firstTrailingBit(others) * KEY_GROUP_SIZE;
        others &= others - 1u;
        let one = keyed(i, choices[i].vertex_count);
        keys[i] = one.key;
        morphs[i] = one.morph;
    }
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
