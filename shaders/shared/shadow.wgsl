// The sun's shadow: cascades of depth maps. Needs light.wgsl.

@group(1) @binding(0) var<uniform> shadow: ShadowConfig;
// Depths as plain numbers: OpenGL's shading language loads no texels of depth textures.
@group(1) @binding(1) var shadow_map: texture_2d_array<f32>;

// Texels of the map that a point is moved along its normal, and how many more where the sun only grazes it.
const NORMAL_OFFSET: f32 = 1.0;
const GRAZING_OFFSET: f32 = 1.7;

// Frames without shadows are drawn without a look at a map.
override HAS_SHADOWS: bool = true;

// Where a point looks for its shadow.
struct ShadowPlace {
    // Number of the map, that of maps where none has it.
    map: u32,
    // In the map: x and y -1 to 1.
    at: vec3f,
}

// The finest map that a point is in. Reads none: adapters that take both sides of every branch would read all of them.
fn shadow_place(position: vec3f, normal: vec3f) -> ShadowPlace {
    let towards = dot(normal, SUN_DIRECTION);
    let rim = 1.0 - 3.0 / f32(shadow.side);
    var place = ShadowPlace(select(0u, shadow.cascade_count, towards <= 0.0), vec3f(0.0));
    while place.map < shadow.cascade_count {
        let cascade = shadow.cascades[place.map];
        let offset = cascade.texel_m * (NORMAL_OFFSET + GRAZING_OFFSET * (1.0 - towards));
        place.at = (cascade.clip_from_world * vec4f(position + normal * offset, 1.0)).xyz;
        if max(abs(place.at.x), abs(place.at.y)) < rim && place.at.z < 1.0 {
            break;
        }
        place.map += 1u;
    }
    return place;
}

// The share of the sun that reaches a point: 0 in shadow, 1 outside, between where the edge runs through the texels around.
// `normal`: unit length.
fn sun_share(position: vec3f, normal: vec3f) -> f32 {
    if !HAS_SHADOWS {
        return 1.0;
    }
    let place = shadow_place(position, normal);
    var share = 1.0;
    // One turn or none. Adapters that work on groups of pixels go through it once; rows beyond the first cost nothing where nobody takes them.
    for (var c = place.map; c < shadow.cascade_count; c = shadow.cascade_count) {
        // Four taps of the hardware's filter half a texel aside, as three texels by three: each is read once.
        let texels = f32(shadow.side);
        let middle = vec2f(place.at.x * 0.5 + 0.5, 0.5 - place.at.y * 0.5) * texels;
        let corner = floor(middle);
        let part = middle - corner;
        let x = vec3f(0.5 - 0.5 * part.x, 0.5, 0.5 * part.x);
        let y = vec3f(0.5 - 0.5 * part.y, 0.5, 0.5 * part.y);
        let first = vec2i(corner) - 1;
        share = 0.0;
        for (var row = 0; row < 3; row++) {
            let depths = vec3f(
                textureLoad(shadow_map, first + vec2i(0, row), c, 0).x,
                textureLoad(shadow_map, first + vec2i(1, row), c, 0).x,
                textureLoad(shadow_map, first + vec2i(2, row), c, 0).x,
            );
            share += dot(x, select(vec3f(0.0), vec3f(1.0), vec3f(place.at.z) <= depths)) * y[row];
        }
        if c + 1u == shadow.cascade_count {
            share = mix(share, 1.0, smoothstep(0.9, 0.99, max(abs(place.at.x), abs(place.at.y))));
        }
    }
    return share;
}
