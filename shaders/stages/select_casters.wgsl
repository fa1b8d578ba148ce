// Who throws a shadow into a cascade, and at which level. Twin: crowd-stages/src/cpu/select_casters.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> shadow: ShadowConfig;
@group(0) @binding(2) var<uniform> which: CascadeStep;
@group(0) @binding(3) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(4) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(5) var<storage, read> error_lods: array<LodRecord>;
// What the camera sees.
@group(0) @binding(6) var<storage, read> choices: array<LodChoice>;
@group(0) @binding(7) var<storage, read_write> casters: array<LodChoice>;
@group(0) @binding(8) var<storage, read> bucket_sets: array<BucketSet>;
@group(0) @binding(9) var<storage, read> buckets: array<BucketRecord>;

// Half texels at a map's rim that may not be read: those of the filter and of the offsets along normals.
const FINER_TEXELS: f32 = 16.0;

// Height in texels below which somebody may be dots.
const DOTS_BELOW_TEXELS: f32 = 8.0;

// Whether all that a sphere may shade finds its shadow in a finer map: light falls along the map's depth, so that is what lies
// behind its outline.
fn is_in_finer(center: vec3f, radius: f32) -> bool {
    if which.cascade == 0u {
        return false;
    }
    let finer = shadow.cascades[which.cascade - 1u];
    let at = finer.clip_from_world * vec4f(center, 1.0);
    return max(abs(at.x), abs(at.y)) + radius / finer.half_m <= 1.0 - FINER_TEXELS / f32(shadow.side);
}

// Whether a sphere and its shadow down to the floor meet the frustum.
fn shadow_may_show(center: vec3f, radius: f32) -> bool {
    let end = center - SUN_DIRECTION * (max(center.y + radius - shadow.floor_m, 0.0) / SUN_DIRECTION.y);
    var shows = true;
    for (var p = 0u; p < 6u; p++) {
        let plane = config.planes[p];
        shows = shows && max(dot(plane.xyz, center), dot(plane.xyz, end)) + plane.w >= -radius;
    }
    return shows;
}

// Dots for somebody of a few texels, about one a texel of their height fewer vertices than the coarsest mesh and no more triangles; 0: the mesh.
fn dots_of(radius: f32, cascade: Cascade, coarsest: LodRecord) -> u32 {
    let height = radius / (0.55 * cascade.texel_m);
    let may_be = config.dot_area_px2 > 0.0 && height < DOTS_BELOW_TEXELS;
    if !may_be {
        return 0u;
    }
    var dots = 1u << firstLeadingBit(u32(max(height, 1.0)));
    while dots > 0u && (dots * DOT_VERTICES >= coarsest.vertex_count || dots > max(coarsest.triangle_count, 1u)) {
        dots /= 2u;
    }
    return dots;
}

// The level next coarser than that of so many vertices, or the coarsest.
fn coarser_than(character: u32, vertex_count: u32) -> LodChoice {
    let levels = bucket_sets[character];
    let coarser = buckets[bucket_of_level(levels, max(level_of(levels, vertex_count), 1u) - 1u)];
    return LodChoice(coarser.vertex_count, coarser.triangle_count);
}

@compute @workgroup_size(BLOCK_SIZE)
fn select_casters(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let instance = instances[i];
    let sphere = world_sphere(instance, clips[instance.clip], clips[leaving_clip(instance)]);
    let center = sphere.xyz;
    let radius = sphere.w;
    let cascade = shadow.cascades[which.cascade];
    let at = cascade.clip_from_world * vec4f(center, 1.0);
    let meets = instance.scale != 0.0 && max(abs(at.x), abs(at.y)) <= 1.0 + radius / cascade.half_m;
    if !meets || is_in_finer(center, radius) || !shadow_may_show(center, radius) {
        casters[i] = LodChoice(0u, 0u);
        return;
    }
    var level = error_lods[error_entry(instance.character, instance.scale * cascade.details_per_m)];
    let coarsest = error_lods[error_entry(instance.character, 0.0)];
    var seen = choices[i];
    if seen.vertex_count == IMPOSTOR_VERTICES && coarsest.vertex_count > IMPOSTOR_VERTICES {
        // A picture throws the shadow of the coarsest mesh.
        seen = LodChoice(coarsest.vertex_count, coarsest.triangle_count);
    } else if config.morph == 1u && seen.vertex_count > coarsest.vertex_count {
        // It is on its way from there.
        seen = coarser_than(instance.character, seen.vertex_count);
    }
    let dots = dots_of(radius, cascade, coarsest);
    if dots > 0u {
        level = LodRecord(dots * DOT_VERTICES, dots);
    }
    if which.has_choices == 1u && seen.vertex_count > 0u && seen.vertex_count < level.vertex_count {
        level = LodRecord(seen.vertex_count, seen.triangle_count);
    }
    casters[i] = LodChoice(level.vertex_count, level.triangle_count);
}
