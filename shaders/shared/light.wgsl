// Light: the constants and formulas of crowd-raster/src/light.rs; a test compares the constants. Colours are linear.

const SUN_DIRECTION: vec3f = vec3f(0.40, 0.80, 0.4472136);
const SUN_COLOR: vec3f = vec3f(2.0, 1.9, 1.7);
const SKY_AMBIENT: vec3f = vec3f(0.46, 0.52, 0.62);
const GROUND_AMBIENT: vec3f = vec3f(0.26, 0.24, 0.21);
const EXPOSURE: f32 = 0.55;
const SKY_HORIZON: vec3f = vec3f(0.62, 0.72, 0.82);
const SKY_ZENITH: vec3f = vec3f(0.20, 0.38, 0.68);
const GROUND: vec3f = vec3f(0.27, 0.27, 0.25);
const GROUND_LINE: vec3f = vec3f(0.20, 0.20, 0.19);
const FADE_M: f32 = 180.0;
const GROUND_Y_M: f32 = -0.02;
const LINE_WIDTH_M: f32 = 0.03;
const LINE_STRENGTH: f32 = 0.55;
const WIDE_LINE_WIDTH_M: f32 = 0.10;

// Light that a lit surface of white base colour sends to the eye. `normal`: unit length, world space.
fn light_at(normal: vec3f) -> vec3f {
    let ambient = mix(GROUND_AMBIENT, SKY_AMBIENT, normal.y * 0.5 + 0.5);
    let sun = SUN_COLOR * max(0.0, dot(normal, SUN_DIRECTION));
    return (ambient + sun) * EXPOSURE;
}
