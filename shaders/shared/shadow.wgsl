// The sun's shadow: cascades of depth maps. Needs light.wgsl.

@group(1) @binding(0) var<uniform> shadow: ShadowConfig;
@group(1) @binding(1) var shadow_map: texture_depth_2d_array;
@group(1) @binding(2) var shadow_sampler: sampler_comparison;

// Texels of the map that a point is moved along its normal, and how many more where the sun only grazes it.
const NORMAL_OFFSET: f32 = 1.0;
const GRAZING_OFFSET: f32 = 1.7;

// The share of the sun that reaches a point: 0 in shadow, 1 outside, between where the edge runs through the texels around.
// `normal`: unit length.
fn sun_share(position: vec3f, normal: vec3f) -> f32 {
    let towards = dot(normal, SUN_DIRECTION);
    if shadow.cascade_count == 0u || towards <= 0.0 {
        return 1.0;
    }
    let texel = 1.0 / f32(shadow.side);
    for (var c = 0u; c < shadow.cascade_count; c++) {
        let cascade = shadow.cascades[c];
        let offset = cascade.texel_m * (NORMAL_OFFSET + GRAZING_OFFSET * (1.0 - towards));
        let at = cascade.clip_from_world * vec4f(position + normal * offset, 1.0);
        let edge = max(abs(at.x), abs(at.y));
        if edge >= 1.0 - 3.0 * texel || at.z >= 1.0 {
            continue;
        }
        let uv = vec2f(at.x * 0.5 + 0.5, 0.5 - at.y * 0.5);
        var share = 0.0;
        for (var tap = 0u; tap < 4u; tap++) {
            let aside = vec2f(f32(tap & 1u), f32(tap >> 1u)) - 0.5;
            share += textureSampleCompareLevel(shadow_map, shadow_sampler, uv + aside * texel, c, at.z) * 0.25;
        }
        if c + 1u == shadow.cascade_count {
            share = mix(share, 1.0, smoothstep(0.9, 0.99, edge));
        }
        return share;
    }
    return 1.0;
}
