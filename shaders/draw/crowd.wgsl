// The crowd: vertices pulled from the characters' records, skinned, lit per pixel. Materials differ a vertex, so one draw
// serves all characters (Dong 2019 §5). Vertex twin: crowd-stages/src/cpu/pose_instance.rs; pixels: crowd-raster.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> draw: DrawConfig;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(4) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(5) var<storage, read> vertices: array<VertexRecord>;
// Whose each entry is: of the frame's vertex list, or of the list of instances sorted by bucket.
@group(0) @binding(6) var<storage, read> slot_instances: array<u32>;
@group(0) @binding(7) var<storage, read> bases: array<InstanceBase>;
@group(0) @binding(8) var<storage, read> materials: array<MaterialRecord>;
@group(0) @binding(9) var animation: texture_2d_array<f32>;
@group(0) @binding(10) var layers: texture_2d_array<f32>;
@group(0) @binding(11) var layer_sampler: sampler;
@group(0) @binding(12) var<storage, read> collapse_map: array<u32>;
@group(0) @binding(13) var<storage, read> morphs: array<MorphRecord>;

struct Surface {
    @builtin(position) clip_position: vec4f,
    @location(0) world_position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
    @location(4) @interpolate(flat) material: u32,
}

fn place_vertex(i: u32, v: u32) -> Surface {
    let instance = instances[i];
    let character = characters[instance.character];
    let clip = clips[instance.clip];
    let vertex = vertices[character.vertex_offset + v];
    let pair = frame_pair(clip, instance.phase_s, config.time_s);
    let rows = skin_matrix(vertex, clip, character.joint_count, pair);
    // A vector times a matrix of rows: one dot product a row.
    let local = vec4f(vertex.position, 1.0) * rows;
    let turned = vec4f(decode_normal(vertex.normal_oct), 0.0) * rows;

    var surface: Surface;
    surface.world_position = world_from_local(instance, local);
    surface.clip_position = config.clip_from_world * vec4f(surface.world_position, 1.0);
    surface.normal = turn(instance.yaw_rad, turned);
    surface.uv = vertex.uv;
    surface.color = unpack4x8unorm(vertex.color);
    surface.material = character.material_offset + (vertex.material_class & 0xffffu);
    return surface;
}

// One draw for the whole crowd: a vertex index is an entry of the frame's vertex list.
@vertex
fn reformed(@builtin(vertex_index) slot: u32) -> Surface {
    let i = slot_instances[slot];
    return place_vertex(i, slot - bases[i].vertex_base);
}

// One draw an instance at full detail: a vertex index is the character's own.
@vertex
fn full_detail(@builtin(vertex_index) v: u32, @builtin(instance_index) i: u32) -> Surface {
    return place_vertex(i, v);
}

// One draw a bucket: the drawn instance is an entry of the sorted list.
@vertex
fn bucketed(@builtin(vertex_index) v: u32, @builtin(instance_index) entry: u32) -> Surface {
    return place_vertex(slot_instances[entry], v);
}

// The same between two levels: a vertex that the coarser one lacks comes from where that has it, with its normal, texture
// coordinates, colour and matrix. Twin: pose_between in crowd-stages/src/cpu/pose_instance.rs.
@vertex
fn bucketed_morphing(@builtin(vertex_index) v: u32, @builtin(instance_index) entry: u32) -> Surface {
    let i = slot_instances[entry];
    let morph = morphs[i];
    if v < morph.coarser_vertex_count || morph.fraction >= 1.0 {
        return place_vertex(i, v);
    }
    let instance = instances[i];
    let character = characters[instance.character];
    let clip = clips[instance.clip];
    var at = v;
    while at >= morph.coarser_vertex_count {
        let next = collapse_map[character.vertex_offset + at];
        if next >= at {
            break;
        }
        at = next;
    }
    let vertex = vertices[character.vertex_offset + v];
    let origin = vertices[character.vertex_offset + at];
    let pair = frame_pair(clip, instance.phase_s, config.time_s);
    var rows = skin_matrix(vertex, clip, character.joint_count, pair);
    // Neighbours on one joint have one matrix; only others are worth a second one.
    if any(vertex.joints != origin.joints) || any(vertex.weights != origin.weights) {
        let first = skin_matrix(origin, clip, character.joint_count, pair);
        rows = first * (1.0 - morph.fraction) + rows * morph.fraction;
    }
    let position = mix(origin.position, vertex.position, morph.fraction);
    let normal = mix(decode_normal(origin.normal_oct), decode_normal(vertex.normal_oct), morph.fraction);

    var surface: Surface;
    surface.world_position = world_from_local(instance, vec4f(position, 1.0) * rows);
    surface.clip_position = config.clip_from_world * vec4f(surface.world_position, 1.0);
    surface.normal = turn(instance.yaw_rad, vec4f(normal, 0.0) * rows);
    surface.uv = mix(origin.uv, vertex.uv, morph.fraction);
    surface.color = mix(unpack4x8unorm(origin.color), unpack4x8unorm(vertex.color), morph.fraction);
    surface.material = character.material_offset + (vertex.material_class & 0xffffu);
    return surface;
}

// Everyone placed beforehand: attributes are all there is to a vertex.
@vertex
fn placed(
    @location(0) position: vec3f,
    @location(1) normal_oct: u32,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
    @location(4) material: u32,
) -> Surface {
    let clip_position = config.clip_from_world * vec4f(position, 1.0);
    return Surface(clip_position, position, decode_normal(normal_oct), uv, color, material);
}

// One texture coordinate brought into 0..1 by the material's wrap mode. The sampler repeats, so for the others we stay half
// a texel (of the coarser level read) away from the border.
fn wrap(u: f32, mode: u32, half_texel: f32) -> f32 {
    if mode == 0u {
        return u;
    }
    var inside = clamp(u, 0.0, 1.0);
    if mode == 2u {
        inside = 1.0 - abs(fract(u * 0.5) * 2.0 - 1.0);
    }
    return clamp(inside, half_texel, 1.0 - half_texel);
}

fn sample_layer(material: MaterialRecord, uv: vec2f, uv_dx: vec2f, uv_dy: vec2f) -> vec4f {
    let texels = max(length(uv_dx), length(uv_dy)) * draw.layer_side;
    let coarser = ceil(clamp(log2(max(texels, 1.0)), 0.0, log2(draw.layer_side)));
    let half_texel = min(0.5 * exp2(coarser) / draw.layer_side, 0.5);
    let mode_u = (material.flags >> MATERIAL_WRAP_U_SHIFT) & MATERIAL_WRAP_MASK;
    let mode_v = (material.flags >> MATERIAL_WRAP_V_SHIFT) & MATERIAL_WRAP_MASK;
    let wrapped = vec2f(wrap(uv.x, mode_u, half_texel), wrap(uv.y, mode_v, half_texel));
    return textureSampleGrad(layers, layer_sampler, wrapped, material.image, uv_dx, uv_dy);
}

@fragment
fn shade(surface: Surface, @builtin(front_facing) is_front: bool) -> @location(0) vec4f {
    // Derivatives first, while all pixels of a quad are still together; of the unwrapped coordinates, which have no jumps.
    let uv_dx = dpdx(surface.uv);
    let uv_dy = dpdy(surface.uv);
    let across = dpdx(surface.world_position);
    let down = dpdy(surface.world_position);

    let material = materials[surface.material];
    let is_double_sided = (material.flags & MATERIAL_DOUBLE_SIDED) != 0u;
    if !is_front && !is_double_sided {
        discard;
    }
    var base = material.base_color * surface.color;
    if material.image != NONE {
        base *= sample_layer(material, surface.uv, uv_dx, uv_dy);
    }
    if base.a < material.alpha_cutoff {
        discard;
    }
    if (material.flags & MATERIAL_UNLIT) != 0u {
        return vec4f(base.rgb, 1.0);
    }
    var normal = surface.normal;
    if (material.flags & MATERIAL_FLAT) != 0u {
        // The side seen faces the eye, whatever the winding.
        normal = cross(down, across);
        normal *= sign(dot(normal, config.eye - surface.world_position));
    } else if !is_front {
        normal = -normal;
    }
    return vec4f(base.rgb * light_at(normalize(normal)), 1.0);
}
