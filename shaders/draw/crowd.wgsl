// The crowd: vertices of the characters skinned, lit per pixel. Materials differ a vertex, so one draw can serve all characters
// (Dong 2019 §5). Vertex twin: crowd-stages/src/cpu/pose_instance.rs; pixels: crowd-raster.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> draw: DrawConfig;
@group(0) @binding(2) var<storage, read> instances: array<InstanceRecord>;
@group(0) @binding(3) var<storage, read> characters: array<CharacterRecord>;
@group(0) @binding(4) var<storage, read> clips: array<ClipRecord>;
@group(0) @binding(5) var<storage, read> vertices: array<VertexRecord>;
// Whose each entry of the frame's vertex list is.
@group(0) @binding(6) var<storage, read> slot_instances: array<u32>;
@group(0) @binding(7) var<storage, read> bases: array<InstanceBase>;
@group(0) @binding(8) var<storage, read> materials: array<MaterialRecord>;
@group(0) @binding(9) var animation: texture_2d_array<u32>;
@group(0) @binding(10) var layers: texture_2d_array<f32>;
@group(0) @binding(11) var layer_sampler: sampler;
@group(0) @binding(12) var<storage, read> palettes: array<vec4f>;
@group(0) @binding(13) var<storage, read> skinned: array<SkinnedVertex>;

// Palettes were blended beforehand.
override HAS_PALETTES: bool = false;
// Not for everyone: there was no room.
override LACKS_PALETTES: bool = false;

fn has_palette(drawn: DrawnInstance) -> bool {
    return HAS_PALETTES && (!LACKS_PALETTES || drawn.palette_row != NONE);
}

fn joint_matrix(drawn: DrawnInstance, pose: Pose, joint: u32) -> mat3x4f {
    if has_palette(drawn) {
        let row = drawn.palette_row + joint * 3u;
        return mat3x4f(palettes[row], palettes[row + 1u], palettes[row + 2u]);
    }
    return posed_joint(pose, joint, drawn.storage);
}

// Palettes have both clips in them.
fn left_share(drawn: DrawnInstance) -> f32 {
    return select(drawn.leaving_share, 0.0, has_palette(drawn));
}

struct Surface {
    @builtin(position) clip_position: vec4f,
    @location(0) world_position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
    @location(4) @interpolate(flat) material: u32,
}

// A vertex of a mesh: VertexRecord in words of 16 bytes.
struct MeshVertex {
    // Position and normal.
    @location(0) place: vec4u,
    // Texture coordinates, colour, material and class.
    @location(1) looks: vec4u,
    // Joints and weights.
    @location(2) skin: vec4u,
}

// Where it comes from: OriginRecord in words of 16 bytes.
struct MeshOrigin {
    @location(3) place: vec4u,
    // Texture coordinates, colour, number of the vertex that comes from there.
    @location(4) looks: vec4u,
    @location(5) skin: vec4u,
}

// Whose it is: DrawnInstance in words of 16 bytes.
struct Owner {
    // Position and scale.
    @location(6) place: vec4f,
    // Sine and cosine of the yaw, fraction of the morph, blend of the frames.
    @location(7) turn: vec4f,
    // Vertices of the coarser level, first material, texels of two frames.
    @location(8) numbers: vec4u,
    // Where its skinned vertices and its palette begin, rows of that, how its character's joints are stored.
    @location(9) bases: vec4u,
    // Texels of two frames of the clip it leaves, their blend and that clip's share as bits.
    @location(10) leaving: vec4u,
}

fn drawn_of(owner: Owner) -> DrawnInstance {
    let n = owner.numbers;
    let b = owner.bases;
    let t = owner.turn;
    let left = owner.leaving;
    return DrawnInstance(
        owner.place.xyz,
        owner.place.w,
        t.xy,
        t.z,
        t.w,
        n.x,
        n.y,
        n.z,
        n.w,
        b.x,
        b.y,
        b.z,
        b.w,
        left.x,
        left.y,
        bitcast<f32>(left.z),
        bitcast<f32>(left.w),
    );
}

// A vertex between its origin and its own place.
struct Moved {
    position: vec3f,
    normal: vec3f,
    uv: vec2f,
    color: vec4f,
}

fn at_home(vertex: MeshVertex) -> Moved {
    return Moved(
        bitcast<vec3f>(vertex.place.xyz),
        decode_normal(vertex.place.w),
        bitcast<vec2f>(vertex.looks.xy),
        unpack4x8unorm(vertex.looks.z),
    );
}

// Its share of the way; 1 where the coarser level has it, too.
fn share_of(drawn: DrawnInstance, v: u32) -> f32 {
    return select(1.0, drawn.fraction, v >= drawn.coarser_vertex_count);
}

fn on_its_way(vertex: MeshVertex, origin: MeshOrigin, share: f32) -> Moved {
    let home = at_home(vertex);
    return Moved(
        between(bitcast<vec3f>(origin.place.xyz), home.position, share),
        between(decode_normal(origin.place.w), home.normal, share),
        mix(bitcast<vec2f>(origin.looks.xy), home.uv, share),
        mix(unpack4x8unorm(origin.looks.z), home.color, share),
    );
}

// `local`, `turned`: position and normal in the character's own space.
fn surface_of(drawn: DrawnInstance, local: vec3f, turned: vec3f, uv: vec2f, color: vec4f, material: u32) -> Surface {
    var surface: Surface;
    surface.world_position = drawn.position + turn_by(drawn.turn, local * drawn.scale);
    surface.clip_position = config.clip_from_world * vec4f(surface.world_position, 1.0);
    surface.normal = turn_by(drawn.turn, turned);
    surface.uv = uv;
    surface.color = color;
    surface.material = drawn.material_offset + (material & 0xffffu);
    return surface;
}

fn skinned_surface(drawn: DrawnInstance, moved: Moved, rows: mat3x4f, material: u32) -> Surface {
    // A vector times a matrix of rows: one dot product a row.
    let local = vec4f(moved.position, 1.0) * rows;
    let turned = vec4f(moved.normal, 0.0) * rows;
    return surface_of(drawn, local, turned, moved.uv, moved.color, material);
}

// A vertex that does not move between levels.
fn place_vertex(drawn: DrawnInstance, vertex: MeshVertex) -> Surface {
    let rows = skin_matrix(vertex.skin, vertex.skin, 1.0, drawn);
    return skinned_surface(drawn, at_home(vertex), rows, vertex.looks.w);
}

fn draw_of(i: u32) -> DrawnInstance {
    let instance = instances[i];
    let character = characters[instance.character];
    let clip = clips[instance.clip];
    let leaving = clips[leaving_clip(instance)];
    return drawn_instance(instance, character, clip, leaving, MorphRecord(0u, 1.0), config.time_s, NONE, NONE);
}

// One draw for the whole crowd: a vertex index is an entry of the frame's vertex list.
@vertex
fn reformed(@builtin(vertex_index) slot: u32) -> Surface {
    let i = slot_instances[slot];
    let v = slot - bases[i].vertex_base;
    let record = vertices[characters[instances[i].character].vertex_offset + v];
    let vertex = MeshVertex(
        vec4u(bitcast<vec3u>(record.position), record.normal_oct),
        vec4u(bitcast<vec2u>(record.uv), record.color, record.material_class),
        vec4u(record.joints, record.weights),
    );
    return place_vertex(draw_of(i), vertex);
}

// One draw an instance at full detail.
@vertex
fn full_detail(vertex: MeshVertex, @builtin(instance_index) i: u32) -> Surface {
    return place_vertex(draw_of(i), vertex);
}

// One draw a bucket.
@vertex
fn bucketed(vertex: MeshVertex, owner: Owner) -> Surface {
    return place_vertex(drawn_of(owner), vertex);
}

// Depth alone, for the shadow maps.
@vertex
fn bucketed_caster(vertex: MeshVertex, owner: Owner) -> @builtin(position) vec4f {
    let drawn = drawn_of(owner);
    let rows = skin_matrix(vertex.skin, vertex.skin, 1.0, drawn);
    let local = vec4f(bitcast<vec3f>(vertex.place.xyz), 1.0) * rows;
    return config.clip_from_world * vec4f(drawn.position + turn_by(drawn.turn, local * drawn.scale), 1.0);
}

// A vertex in the character's own space: where the crowd's own pass has skinned it, read; else skinned here. Adapters that work on groups of
// vertices run both bodies once; the loop over joints within the second repeats only for those that are skinned here.
fn borrowed_place(drawn: DrawnInstance, vertex: MeshVertex, number: u32) -> vec3f {
    var local = vec3f(0.0);
    for (var is_lent = drawn.vertex_base != NONE; is_lent; is_lent = false) {
        let at = skinned[drawn.vertex_base + number];
        local = vec3f(at.x, at.y, at.z);
    }
    for (var is_alone = drawn.vertex_base == NONE; is_alone; is_alone = false) {
        let rows = skin_matrix(vertex.skin, vertex.skin, 1.0, drawn);
        local = vec4f(bitcast<vec3f>(vertex.place.xyz), 1.0) * rows;
    }
    return local;
}

// The casters of `bucketed_caster` with the vertices of `skin_vertices`.
@vertex
fn borrowed_caster(vertex: MeshVertex, @location(4) origin: vec4u, owner: Owner) -> @builtin(position) vec4f {
    let drawn = drawn_of(owner);
    let local = borrowed_place(drawn, vertex, origin.w);
    return config.clip_from_world * vec4f(drawn.position + turn_by(drawn.turn, local * drawn.scale), 1.0);
}

// The same with what `mask` reads.
@vertex
fn borrowed_masked(vertex: MeshVertex, @location(4) origin: vec4u, owner: Owner) -> Surface {
    let drawn = drawn_of(owner);
    let home = at_home(vertex);
    let local = borrowed_place(drawn, vertex, origin.w);
    return surface_of(drawn, local, home.normal, home.uv, home.color, vertex.looks.w);
}

// One draw a bucket between two levels: a vertex that the coarser one lacks comes from where that has it, with its normal, texture
// coordinates, colour and matrix. Twin: pose_between in crowd-stages/src/cpu/pose_instance.rs.
@vertex
fn bucketed_morphing(vertex: MeshVertex, origin: MeshOrigin, owner: Owner) -> Surface {
    let drawn = drawn_of(owner);
    let share = share_of(drawn, origin.looks.w);
    let rows = skin_matrix(vertex.skin, origin.skin, share, drawn);
    return skinned_surface(drawn, on_its_way(vertex, origin, share), rows, vertex.looks.w);
}

// The same of vertices that `skin_vertices` has skinned.
@vertex
fn bucketed_skinned(@location(1) looks: vec4u, @location(4) origin: vec4u, owner: Owner) -> Surface {
    let drawn = drawn_of(owner);
    let share = share_of(drawn, origin.w);
    let at = skinned[drawn.vertex_base + origin.w];
    let uv = mix(bitcast<vec2f>(origin.xy), bitcast<vec2f>(looks.xy), share);
    let color = mix(unpack4x8unorm(origin.z), unpack4x8unorm(looks.z), share);
    let normal = vec3f(at.normal_x, at.normal_y, at.normal_z);
    var surface = surface_of(drawn, vec3f(at.x, at.y, at.z), normal, uv, color, looks.w);
    if drawn.vertex_base == NONE {
        // There was no room; totals say so. Nothing is drawn, instead of anything.
        surface.clip_position = vec4f(2.0, 2.0, 2.0, 1.0);
    }
    return surface;
}

// The same where not everybody has a place: who has none is skinned here, as in `borrowed_place`.
@vertex
fn bucketed_partly_skinned(vertex: MeshVertex, origin: MeshOrigin, owner: Owner) -> Surface {
    let drawn = drawn_of(owner);
    let share = share_of(drawn, origin.looks.w);
    let moved = on_its_way(vertex, origin, share);
    var local = vec3f(0.0);
    var turned = vec3f(0.0);
    for (var is_placed = drawn.vertex_base != NONE; is_placed; is_placed = false) {
        let at = skinned[drawn.vertex_base + origin.looks.w];
        local = vec3f(at.x, at.y, at.z);
        turned = vec3f(at.normal_x, at.normal_y, at.normal_z);
    }
    for (var is_alone = drawn.vertex_base == NONE; is_alone; is_alone = false) {
        let rows = skin_matrix(vertex.skin, origin.skin, share, drawn);
        local = vec4f(moved.position, 1.0) * rows;
        turned = vec4f(moved.normal, 0.0) * rows;
    }
    return surface_of(drawn, local, turned, moved.uv, moved.color, vertex.looks.w);
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
    return shaded(surface, is_front, uv_dx, uv_dy, across, down);
}

// The colour of a pixel of a mesh; what is cut out or seen from behind is discarded.
fn shaded(surface: Surface, is_front: bool, uv_dx: vec2f, uv_dy: vec2f, across: vec3f, down: vec3f) -> vec4f {
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
    let distance_m = distance(surface.world_position, config.eye);
    if (material.flags & MATERIAL_UNLIT) != 0u {
        return vec4f(through_fog(base.rgb, distance_m, config.fog_per_m), 1.0);
    }
    var normal = surface.normal;
    if (material.flags & MATERIAL_FLAT) != 0u {
        // The side seen faces the eye, whatever the winding.
        normal = cross(down, across);
        normal *= sign(dot(normal, config.eye - surface.world_position));
    } else if !is_front {
        normal = -normal;
    }
    normal = normalize(normal);
    let color = base.rgb * light_at(normal, sun_share(surface.world_position, normal));
    return vec4f(through_fog(color, distance_m, config.fog_per_m), 1.0);
}

// Depth alone, for the shadow maps of crowds of which something is cut out: that throws no shadow.
@fragment
fn mask(surface: Surface) {
    let uv_dx = dpdx(surface.uv);
    let uv_dy = dpdy(surface.uv);
    let material = materials[surface.material];
    if material.alpha_cutoff <= 0.0 {
        return;
    }
    var alpha = material.base_color.a * surface.color.a;
    if material.image != NONE {
        alpha *= sample_layer(material, surface.uv, uv_dx, uv_dy).a;
    }
    if alpha < material.alpha_cutoff {
        discard;
    }
}
