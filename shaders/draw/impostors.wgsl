// Characters a few pixels high as one picture of two triangles each, and the way from the coarsest mesh to it. Compiled with crowd.wgsl,
// whose bindings and inputs it has. What an impostor is: crowd-stages/src/impostors.rs; who bakes it: crowdbake/src/impostors.rs.

@group(2) @binding(0) var<uniform> sheet: ImpostorSheet;
// Linear base colour times coverage, and coverage.
@group(2) @binding(1) var impostor_colors: texture_2d_array<f32>;
// Normal in the character's space, a half more than half of it, and the share that light changes, both times coverage.
@group(2) @binding(2) var impostor_normals: texture_2d_array<f32>;
@group(2) @binding(3) var impostor_sampler: sampler;

// Texels are read this much finer than pixels are: coverage that is averaged twice makes soft edges.
const FINER: f32 = 0.6;

// Samples of a pixel.
override SAMPLES: u32 = 1u;

struct ImpostorSurface {
    @builtin(position) clip_position: vec4f,
    @location(0) world_position: vec3f,
    // From the tile's corner.
    @location(1) texel: vec2f,
    // The tile's corner in texels, and its layer.
    @location(2) @interpolate(flat) tile: vec3u,
    // Sine and cosine of the yaw, the impostor's share of the pixels, radius of the sphere.
    @location(3) @interpolate(flat) look: vec4f,
    @location(4) @interpolate(flat) instance: u32,
}

// A corner of the mesh or of the impostor.
struct FadingSurface {
    @builtin(position) clip_position: vec4f,
    @location(0) world_position: vec3f,
    @location(1) normal: vec3f,
    @location(2) uv: vec2f,
    @location(3) color: vec4f,
    // NONE: of the impostor.
    @location(4) @interpolate(flat) material: u32,
    @location(5) @interpolate(flat) tile: vec3u,
    @location(6) @interpolate(flat) look: vec4f,
    @location(7) @interpolate(flat) instance: u32,
}

// A colour for some of a pixel's samples.
struct Masked {
    @location(0) color: vec4f,
    @builtin(sample_mask) samples: u32,
}

const TAU: f32 = 2.0 * PI;

// The pose of a clip that is nearest to what an instance plays; the first of all where its clip has none.
fn pose_of(drawn: DrawnInstance, clip: u32, character: CharacterRecord, corner: MeshVertex) -> u32 {
    let first_pose = corner.place.z;
    let pose_count = corner.place.w;
    let number = clip - character.clip_offset;
    if number >= corner.looks.x {
        return first_pose;
    }
    let leaves = drawn.leaving_share > 0.5;
    let texel = select(drawn.first_texel, drawn.leaving_first_texel, leaves);
    let blend = select(drawn.blend, drawn.leaving_blend, leaves);
    let frame = f32((texel - clips[clip].texel_offset) / frame_texels(character)) + blend;
    let turn = frame / f32(max(clips[clip].frame_count, 2u) - 1u);
    return first_pose + number * pose_count + min(u32(turn * f32(pose_count)), pose_count - 1u);
}

// A corner is an ImpostorCorner in the words of a mesh's vertex.
fn impostor_corner(drawn: DrawnInstance, corner: MeshVertex) -> ImpostorSurface {
    let character = characters[corner.place.y];
    // gather_drawn puts the clip that counts more here, and the instance's number.
    let clip = drawn.vertex_base;
    let has_poses = clip - character.clip_offset < corner.looks.x;
    let sphere = clips[select(character.clip_offset, clip, has_poses)].sphere;
    let center = drawn.position + turn_by(drawn.turn, sphere.xyz * drawn.scale);
    let radius = sphere.w * drawn.scale;
    let towards_eye = normalize(config.eye - center);
    // Seen from above nothing has a right side; any will do.
    let across = length(towards_eye.xz);
    let level = select(vec2f(0.0, 1.0), towards_eye.xz / across, across > 1e-4);
    let turned_back = turn_by(vec2f(-drawn.turn.x, drawn.turn.y), vec3f(level.x, 0.0, level.y));
    let azimuths = f32(sheet.azimuth_count);
    let azimuth = u32(atan2(turned_back.x, turned_back.z) / TAU * azimuths + azimuths + 0.5) % sheet.azimuth_count;
    let elevations = f32(sheet.elevation_count);
    let height = asin(clamp(towards_eye.y, -1.0, 1.0)) / (0.5 * PI) * elevations;
    let step = clamp(round(height - 0.25), 0.0, elevations - 1.0);
    // It faces the eye around, and stands upwards as it was seen: so it is foreshortened like what it stands for.
    let elevation_rad = (step + 0.25) / elevations * 0.5 * PI;
    let right = vec3f(level.y, 0.0, -level.x);
    let up = vec3f(-level.x * sin(elevation_rad), cos(elevation_rad), -level.y * sin(elevation_rad));
    // No more of the tile than the character needs.
    let bounds = unpack4x8unorm(corner.looks.y) * 255.0;
    let number = corner.place.x;
    let texel = vec2f(
        select(bounds.x, bounds.z, number == 1u || number == 2u),
        select(bounds.w, bounds.y, number >= 2u),
    );
    let from_center = texel / f32(sheet.tile_px) * 2.0 - 1.0;
    let place = center + (right * from_center.x - up * from_center.y) * radius;
    let pose = pose_of(drawn, clip, character, corner);
    let row = (pose % sheet.poses_a_layer) * sheet.elevation_count + u32(step);
    var surface: ImpostorSurface;
    surface.clip_position = config.clip_from_world * vec4f(place, 1.0);
    surface.world_position = place;
    surface.texel = texel;
    surface.tile = vec3u(azimuth * sheet.tile_px, row * sheet.tile_px, pose / sheet.poses_a_layer);
    surface.look = vec4f(drawn.turn, drawn.fraction, radius);
    surface.instance = drawn.palette_row;
    return surface;
}

@vertex
fn impostors(vertex: MeshVertex, owner: Owner) -> ImpostorSurface {
    return impostor_corner(drawn_of(owner), vertex);
}

@vertex
fn fading(vertex: MeshVertex, owner: Owner) -> FadingSurface {
    let drawn = drawn_of(owner);
    if vertex.looks.w == NONE {
        let corner = impostor_corner(drawn, vertex);
        return FadingSurface(
            corner.clip_position,
            corner.world_position,
            vec3f(0.0, 1.0, 0.0),
            corner.texel,
            vec4f(1.0),
            NONE,
            corner.tile,
            corner.look,
            corner.instance,
        );
    }
    let mesh = place_vertex(drawn, vertex);
    return FadingSurface(
        mesh.clip_position,
        mesh.world_position,
        mesh.normal,
        mesh.uv,
        mesh.color,
        mesh.material,
        vec3u(0u),
        vec4f(drawn.turn, drawn.fraction, 0.0),
        drawn.palette_row,
    );
}

// Mean of light_at over normals whose mean is given: the shorter it is, the farther they lie apart. What of it is linear, the mean has; the
// sun's share of a normal never falls below zero, so its mean is that of the positive part of a number with this mean and a third of the
// normals' variance (a bell curve's, to a hundredth or two: half of c + sqrt(c^2 + 2 v / pi)). A unit normal gives light_at.
fn mean_light(mean_normal: vec3f, share: f32) -> vec3f {
    let variance = max(0.0, 1.0 - dot(mean_normal, mean_normal)) / 3.0;
    let towards = dot(mean_normal, SUN_DIRECTION);
    let sunlit = 0.5 * (towards + sqrt(towards * towards + variance * (2.0 / PI)));
    let ambient = mix(GROUND_AMBIENT, SKY_AMBIENT, mean_normal.y * 0.5 + 0.5);
    return (ambient + SUN_COLOR * (sunlit * share)) * EXPOSURE;
}

// Colour and coverage of a texel, lit.
fn impostor_at(texel: vec2f, across: vec2f, down: vec2f, tile: vec3u, look: vec4f, world_position: vec3f) -> vec4f {
    let dx = across * FINER;
    let dy = down * FINER;
    // Half a texel (of the coarser level read) away from the other tiles.
    let coarser = ceil(clamp(log2(max(max(length(dx), length(dy)), 1.0)), 0.0, log2(f32(sheet.tile_px)) - 1.0));
    let half_texel = 0.5 * exp2(coarser);
    let inside = clamp(texel, vec2f(half_texel), vec2f(f32(sheet.tile_px) - half_texel));
    let size = vec2f(textureDimensions(impostor_colors));
    let at = (vec2f(tile.xy) + inside) / size;
    let color = textureSampleGrad(impostor_colors, impostor_sampler, at, tile.z, dx / size, dy / size);
    let stored = textureSampleGrad(impostor_normals, impostor_sampler, at, tile.z, dx / size, dy / size);
    // A byte of 128 is 0.
    let coverage = max(color.a, 1.0 / 255.0);
    let turned = turn_by(look.xy, (stored.xyz * (255.0 / 127.0) - 128.0 / 127.0) / coverage);
    let length = length(turned);
    let normal = select(vec3f(0.0, 1.0, 0.0), turned / length, length > 1e-3);
    // No mean of normals is longer than they are, but for rounding.
    let mean_normal = turned / max(length, 1.0);
    // The flat picture stands in the shadow of its own body: look where that ends.
    let light = mean_light(mean_normal, sun_share(world_position + SUN_DIRECTION * look.w, normal));
    let base = color.rgb / coverage * mix(vec3f(1.0), light, min(stored.a / coverage, 1.0));
    return vec4f(through_fog(base, distance(world_position, config.eye), config.fog_per_m), color.a);
}

// A number from 0 to 1 that is another for each pixel of four by four (Bayer 1973), and that starts elsewhere for each instance.
fn threshold_at(pixel: vec2f, instance: u32) -> f32 {
    let hash = instance * 2654435769u;
    let at = vec2u(pixel) + vec2u(hash >> 30u, hash >> 28u);
    let x = at.x ^ at.y;
    let rank = ((x & 1u) << 3u) | ((at.y & 1u) << 2u) | (x & 2u) | ((at.y & 2u) >> 1u);
    return (f32(rank) + 0.5) / 16.0;
}

// So many of a pixel's samples, beginning at another one for each instance, so that one does not hide behind another's.
fn first_samples(share: f32, threshold: f32, instance: u32) -> u32 {
    let count = min(u32(max(share, 0.0) * f32(SAMPLES) + threshold), SAMPLES);
    let bits = (1u << count) - 1u;
    let spin = instance % SAMPLES;
    return ((bits << spin) | (bits >> (SAMPLES - spin))) & ((1u << SAMPLES) - 1u);
}

@fragment
fn shade_impostor(surface: ImpostorSurface) -> Masked {
    let dx = dpdx(surface.texel);
    let dy = dpdy(surface.texel);
    let color = impostor_at(surface.texel, dx, dy, surface.tile, surface.look, surface.world_position);
    let threshold = threshold_at(surface.clip_position.xy, surface.instance);
    let samples = first_samples(color.a, threshold, surface.instance);
    if samples == 0u {
        discard;
    }
    return Masked(vec4f(color.rgb, 1.0), samples);
}

// The impostor has its share of the samples, the mesh the others.
@fragment
fn shade_fading(surface: FadingSurface, @builtin(front_facing) is_front: bool) -> Masked {
    let uv_dx = dpdx(surface.uv);
    let uv_dy = dpdy(surface.uv);
    let across = dpdx(surface.world_position);
    let down = dpdy(surface.world_position);
    let threshold = threshold_at(surface.clip_position.xy, surface.instance);
    var color: vec4f;
    var samples: u32;
    if surface.material == NONE {
        color = impostor_at(surface.uv, uv_dx, uv_dy, surface.tile, surface.look, surface.world_position);
        samples = first_samples(color.a * surface.look.z, threshold, surface.instance);
    } else {
        let mesh = Surface(
            surface.clip_position,
            surface.world_position,
            surface.normal,
            surface.uv,
            surface.color,
            surface.material,
        );
        color = shaded(mesh, is_front, uv_dx, uv_dy, across, down);
        samples = first_samples(1.0, 0.0, 0u) & ~first_samples(surface.look.z, threshold, surface.instance);
    }
    if samples == 0u {
        discard;
    }
    return Masked(vec4f(color.rgb, 1.0), samples);
}
