// The sun's shadow: cascades of depth maps. Needs light.wgsl.

@group(1) @binding(0) var<uniform> shadow: ShadowConfig;
// Depths as plain numbers: OpenGL's shading language loads no texels of depth textures.
@group(1) @binding(1) var shadow_map: texture_2d_array<f32>;

// Texels of the map that a point is moved along its normal, and how many more where the sun only grazes it.
const NORMAL_OFFSET: f32 = 1.0;
const GRAZING_OFFSET: f32 = 1.7;

// Frames without shadows are drawn without a look at a map.
override HAS_SHADOWS: bool = true;

// Directions of a map's rows and columns: across and along the sun's rays' slope, both at right angles to them, unit length; as in cascades.rs.
const SUN_ASIDE: f32 = sqrt(SUN_DIRECTION.x * SUN_DIRECTION.x + SUN_DIRECTION.z * SUN_DIRECTION.z);
const SUN_ACROSS: vec3f = vec3f(SUN_DIRECTION.z, 0.0, -SUN_DIRECTION.x) / SUN_ASIDE;
const SUN_ALONG: vec3f = vec3f(
    -SUN_DIRECTION.x * SUN_DIRECTION.y / SUN_ASIDE,
    SUN_ASIDE,
    -SUN_DIRECTION.z * SUN_DIRECTION.y / SUN_ASIDE,
);

// Where a point looks for its shadow.
struct ShadowPlace {
    // Number of the map, MAX_CASCADES where none has it.
    map: u32,
    // In the map: x and y -1 to 1.
    at: vec3f,
}

// Something as the sun sees it: right, up and towards it, metres.
fn from_sun(v: vec3f) -> vec3f {
    return vec3f(dot(v, SUN_ACROSS), dot(v, SUN_ALONG), dot(v, SUN_DIRECTION));
}

// The place that was found in coarser maps, or that in a finer one where the point is in it. All maps are turned alike, so what differs is
// where they lie and how large they are: six numbers, which adapters that work on groups of pixels read once where `number` is a constant and
// gather for each pixel where it is not.
fn place_in(number: u32, cascade: Cascade, position: vec3f, offset: vec3f, coarser: ShadowPlace) -> ShadowPlace {
    let from_sun = position + offset * cascade.texel_m;
    let scale = 1.0 / cascade.half_m;
    let at = from_sun * vec3f(scale, scale, -cascade.depth_per_m) + cascade.clip_from_world[3].xyz;
    let rim = 1.0 - 3.0 / f32(shadow.side);
    // No && or branch: those adapters take both sides.
    let holds = (number < shadow.cascade_count) & (max(abs(at.x), abs(at.y)) < rim) & (at.z < 1.0);
    return ShadowPlace(select(coarser.map, number, holds), select(coarser.at, at, holds));
}

// The finest map that a point is in. Reads none.
fn shadow_place(position: vec3f, normal: vec3f) -> ShadowPlace {
    let seen = from_sun(position);
    let turned = from_sun(normal);
    let towards = turned.z;
    let offset = turned * (NORMAL_OFFSET + GRAZING_OFFSET * (1.0 - towards));
    var place = ShadowPlace(MAX_CASCADES, vec3f(0.0));
    place = place_in(3u, shadow.cascades[3], seen, offset, place);
    place = place_in(2u, shadow.cascades[2], seen, offset, place);
    place = place_in(1u, shadow.cascades[1], seen, offset, place);
    place = place_in(0u, shadow.cascades[0], seen, offset, place);
    place.map = select(place.map, MAX_CASCADES, towards <= 0.0);
    return place;
}

// How much of three texels in a row the sun reaches. `x`: what each counts.
fn lit_row(first: vec2i, map: u32, depth: f32, x: vec3f) -> f32 {
    let depths = vec3f(
        textureLoad(shadow_map, first, map, 0).x,
        textureLoad(shadow_map, first + vec2i(1, 0), map, 0).x,
        textureLoad(shadow_map, first + vec2i(2, 0), map, 0).x,
    );
    return dot(x, select(vec3f(0.0), vec3f(1.0), vec3f(depth) <= depths));
}

// The share of the sun that reaches a point: 0 in shadow, 1 outside, between where the edge runs through the texels around.
// `normal`: unit length.
fn sun_share(position: vec3f, normal: vec3f) -> f32 {
    if !HAS_SHADOWS {
        return 1.0;
    }
    let place = shadow_place(position, normal);
    // Who is in no map looks, too, and does not mind: where adapters work on groups of pixels, a branch or a loop costs more than it spares.
    let map = min(place.map, MAX_CASCADES - 1u);
    // Four taps of the hardware's filter half a texel aside, as three texels by three: each is read once.
    let middle = vec2f(place.at.x * 0.5 + 0.5, 0.5 - place.at.y * 0.5) * f32(shadow.side);
    let corner = floor(middle);
    let part = middle - corner;
    let x = vec3f(0.5 - 0.5 * part.x, 0.5, 0.5 * part.x);
    let y = vec3f(0.5 - 0.5 * part.y, 0.5, 0.5 * part.y);
    let first = vec2i(corner) - 1;
    var share = lit_row(first, map, place.at.z, x) * y.x;
    share += lit_row(first + vec2i(0, 1), map, place.at.z, x) * y.y;
    share += lit_row(first + vec2i(0, 2), map, place.at.z, x) * y.z;
    if map + 1u == shadow.cascade_count {
        share = mix(share, 1.0, smoothstep(0.9, 0.99, max(abs(place.at.x), abs(place.at.y))));
    }
    return select(1.0, share, place.map < MAX_CASCADES);
}
