// Bounding sphere against frustum, projected area, weight. Twin: crowd-stages/src/cpu/cull_instances.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(2) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(3) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(4) var<storage, read_write> culled: array<CullRecord>;

const PI: f32 = 3.14159265;

@compute @workgroup_size(BLOCK_SIZE)
fn cull_instances(@builtin(workgroup_id) workgroup: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = group_number(workgroup) * BLOCK_SIZE + lane;
    if i >= config.instance_count {
        return;
    }
    let instance = instances[i];
    let sphere = world_sphere(instance, clips[instance.clip], clips[leaving_clip(instance)]);
    let center = sphere.xyz;
    let radius = sphere.w;

    // Of no size: nobody.
    var visible = instance.scale != 0.0;
    for (var p = 0u; p < 6u; p++) {
        let plane = config.planes[p];
        visible = visible && dot(plane.xyz, center) + plane.w >= -radius;
    }
    if !visible {
        culled[i] = CullRecord(0u, 0.0, 0.0, distance(center, config.eye));
        return;
    }

    let distance_m = distance(center, config.eye);
    // Inside the sphere the projection has no meaning: the sphere fills the picture, no more.
    let nearest = max(max(distance_m, radius), 1e-6);
    let radius_px = config.focal_px * radius / nearest;
    let area_px2 = PI * radius_px * radius_px;
    var weight = pow(max(area_px2, 1e-12), config.inverse_alpha);
    if config.weight == WEIGHT_AREA_DISTANCE {
        let detail = f32(characters[instance.character].vertex_count);
        weight = pow(max(area_px2 / nearest, 1e-12), config.inverse_alpha)
            * pow(max(detail, 1.0), 1.0 - config.inverse_alpha);
    }
    if config.weight == WEIGHT_ERROR {
        weight = config.focal_px * instance.scale / nearest;
    }
    culled[i] = CullRecord(instance.character + 1u, weight, area_px2, distance_m);
}
