// Light: the constants and formulas of crowd-raster/src/light.rs; a test compares the constants. Colours are linear.

const SUN_DIRECTION: vec3f = vec3f(0.451129, 0.701757, 0.551380);
const SUN_COLOR: vec3f = vec3f(2.2, 1.98, 1.62);
const SKY_AMBIENT: vec3f = vec3f(0.42, 0.49, 0.60);
const GROUND_AMBIENT: vec3f = vec3f(0.27, 0.24, 0.20);
const EXPOSURE: f32 = 0.55;
const SKY_HORIZON: vec3f = vec3f(0.70, 0.78, 0.86);
const SKY_ZENITH: vec3f = vec3f(0.15, 0.33, 0.68);
const GROUND: vec3f = vec3f(0.31, 0.29, 0.245);
const GROUND_LINE: vec3f = vec3f(0.23, 0.215, 0.18);
const FADE_M: f32 = 140.0;
const GROUND_Y_M: f32 = -0.02;
const LINE_WIDTH_M: f32 = 0.03;
const LINE_STRENGTH: f32 = 0.55;
const WIDE_LINE_WIDTH_M: f32 = 0.10;
const FOG_LAYER_M: f32 = 60.0;

// Light that a lit surface of white base colour sends to the eye. `normal`: unit length, world space; `share`: of the sun that
// reaches it.
fn light_at(normal: vec3f, share: f32) -> vec3f {
    let ambient = mix(GROUND_AMBIENT, SKY_AMBIENT, normal.y * 0.5 + 0.5);
    let sun = SUN_COLOR * (max(0.0, dot(normal, SUN_DIRECTION)) * share);
    return (ambient + sun) * EXPOSURE;
}

// What is seen of a colour through so many metres of fog.
fn through_fog(color: vec3f, distance_m: f32, fog_per_m: f32) -> vec3f {
    return mix(SKY_HORIZON, color, exp(-distance_m * fog_per_m));
}
