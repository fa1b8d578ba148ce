// Sky and ground in one triangle over the whole picture; the formulas of crowd-raster/src/ground.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> draw: DrawConfig;

// Ground beyond the far plane is still drawn, at the largest depth below 1.
const FARTHEST: f32 = 0.99999994;

// Depth is 1 near and 0 far.
override REVERSED: bool = false;

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4f {
    let corner = vec2f(f32((vertex << 1u) & 2u), f32(vertex & 2u));
    return vec4f(corner * 2.0 - 1.0, 1.0, 1.0);
}

struct Backdrop {
    @location(0) color: vec4f,
    @builtin(frag_depth) depth: f32,
}

// The fog is a layer: less of it is before the zenith than before the horizon.
fn sky_color(direction: vec3f) -> vec3f {
    let up = clamp(normalize(direction).y, 0.0, 1.0);
    let sky = mix(SKY_HORIZON, SKY_ZENITH, sqrt(up));
    return through_fog(sky, FOG_LAYER_M / max(up, 1e-4), config.fog_per_m);
}

fn edge(v: f32, width: f32) -> f32 {
    return floor(v) * width + min(v - floor(v), width);
}

fn stripes(u: f32, foot: f32, width: f32) -> f32 {
    return clamp((edge(u + foot * 0.5, width) - edge(u - foot * 0.5, width)) / foot, 0.0, 1.0);
}

fn lines(p: vec2f, foot: vec2f, period: f32, width_m: f32) -> f32 {
    let width = width_m / period;
    let x = stripes(p.x / period + width * 0.5, foot.x / period, width);
    let z = stripes(p.y / period + width * 0.5, foot.y / period, width);
    return 1.0 - (1.0 - x) * (1.0 - z);
}

// What is left of the ground's colour in the shadow.
fn ground_shade(p: vec3f) -> vec3f {
    if !HAS_SHADOWS {
        return vec3f(1.0);
    }
    let up = vec3f(0.0, 1.0, 0.0);
    return light_at(up, sun_share(p, up)) / light_at(up, 1.0);
}

fn ground_color(p: vec2f, foot: vec2f, distance_m: f32, shade: vec3f) -> vec3f {
    let narrow = lines(p, foot, 1.0, LINE_WIDTH_M);
    let wide = lines(p, foot, 10.0, WIDE_LINE_WIDTH_M);
    let near = exp(-distance_m / FADE_M);
    return mix(SKY_HORIZON, mix(GROUND, GROUND_LINE, max(LINE_STRENGTH * narrow, wide)) * shade, near);
}

@fragment
fn backdrop(@builtin(position) pixel: vec4f) -> Backdrop {
    let ndc = vec2f(pixel.x / draw.width_px * 2.0 - 1.0, 1.0 - pixel.y / draw.height_px * 2.0);
    let d = draw.ray_x * ndc.x + draw.ray_y * ndc.y + draw.ray_w;
    let nothing = select(1.0, 0.0, REVERSED);
    if !(dot(d, d) > 0.0) {
        return Backdrop(vec4f(SKY_HORIZON, 1.0), nothing);
    }
    let t = (GROUND_Y_M - config.eye.y) / d.y;
    if d.y == 0.0 || !(t > 0.0) {
        return Backdrop(vec4f(sky_color(d), 1.0), nothing);
    }
    let p = config.eye + t * d;
    let clip = config.clip_from_world * vec4f(p, 1.0);
    let at = clip.z / clip.w;
    let depth = select(min(at, FARTHEST), max(at, 1.0 - FARTHEST), REVERSED);
    if !select(depth >= 0.0, depth <= 1.0, REVERSED) {
        return Backdrop(vec4f(sky_color(d), 1.0), nothing);
    }
    let dx = draw.ray_x * (2.0 / draw.width_px);
    let dy = draw.ray_y * (-2.0 / draw.height_px);
    let px = t * (dx - d * (dx.y / d.y));
    let py = t * (dy - d * (dy.y / d.y));
    let foot = max(max(abs(px.xz), abs(py.xz)), vec2f(1e-4));
    let distance_m = distance(p, config.eye);
    let ground = ground_color(p.xz, foot, distance_m, ground_shade(p));
    return Backdrop(vec4f(through_fog(ground, distance_m, config.fog_per_m), 1.0), depth);
}
