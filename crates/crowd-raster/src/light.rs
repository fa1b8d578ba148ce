//! Light: constants and formulas, the same in `shaders/shared/light.wgsl` (a test compares the constants).
//!
//! All colours are linear light until [`crate::srgb`] encodes them at the very end (a GPU's sRGB target does the same).
//!
//! ```text
//! base      = material.base_color * texture(uv) * vertex_color / 255          (rgba, linear; texture decoded from sRGB)
//! discard     when base.a < material.alpha_cutoff
//! n         = normalize(interpolated world normal)                            (flat: cross(p1 - p0, p2 - p0))
//! n         = -n on a back face of a double-sided material
//! ambient   = mix(GROUND_AMBIENT, SKY_AMBIENT, n.y * 0.5 + 0.5)
//! sun       = SUN_COLOR * max(0, dot(n, SUN_DIRECTION))
//! colour    = base.rgb * (ambient + sun) * EXPOSURE                           (unlit: base.rgb)
//! output    = srgb_encode(clamp(colour, 0, 1))
//! ```
//!
//! Texture level, in texels of level 0 (w, h its size): `lod = log2(max(length(duv/dx * (w, h)), length(duv/dy * (w, h))))`,
//! clamped to the levels there are, linear between two levels; magnification is bilinear too.
//!
//! Sky and ground: see [`crate::ground`], whose formulas use the constants here.

use glam::Vec3;

/// Towards the sun, unit length.
pub const SUN_DIRECTION: [f32; 3] = [0.451_129, 0.701_757, 0.551_380];
/// Linear radiance of the sun.
pub const SUN_COLOR: [f32; 3] = [2.2, 1.98, 1.62];
/// Linear ambient from above.
pub const SKY_AMBIENT: [f32; 3] = [0.42, 0.49, 0.60];
/// Linear ambient from below.
pub const GROUND_AMBIENT: [f32; 3] = [0.27, 0.24, 0.20];
/// Reflected share: colour = base * (ambient + sun * max(0, n.l)) * EXPOSURE.
pub const EXPOSURE: f32 = 0.55;
/// Linear sky at the horizon.
pub const SKY_HORIZON: [f32; 3] = [0.70, 0.78, 0.86];
/// Linear sky overhead.
pub const SKY_ZENITH: [f32; 3] = [0.15, 0.33, 0.68];
/// Linear ground.
pub const GROUND: [f32; 3] = [0.31, 0.29, 0.245];
/// Linear ground lines, one a metre, stronger each ten.
pub const GROUND_LINE: [f32; 3] = [0.23, 0.215, 0.18];
/// Ground fades into the horizon colour over this distance, metres (1 - exp(-d / this)).
pub const FADE_M: f32 = 140.0;
/// Height of the drawn ground, metres: a little under the feet, so that soles do not flicker in it.
pub const GROUND_Y_M: f32 = -0.02;
/// Width of the line drawn each metre, metres.
pub const LINE_WIDTH_M: f32 = 0.03;
/// Strength of the line drawn each metre, 0 to 1.
pub const LINE_STRENGTH: f32 = 0.55;
/// Width of the line drawn each ten metres, metres; its strength is 1.
pub const WIDE_LINE_WIDTH_M: f32 = 0.10;

/// Height of the fog over the eye through which the sky is seen, metres.
pub const FOG_LAYER_M: f32 = 60.0;

/// Light that a lit surface of white base colour sends to the eye, linear RGB. `normal`: unit length, world space.
pub fn light_at(normal: Vec3) -> Vec3 {
    let up = normal.y * 0.5 + 0.5;
    let ambient = mix(Vec3::from(GROUND_AMBIENT), Vec3::from(SKY_AMBIENT), up);
    let sun = Vec3::from(SUN_COLOR) * normal.dot(Vec3::from(SUN_DIRECTION)).max(0.0);
    (ambient + sun) * EXPOSURE
}

/// What is seen of a linear colour through so many metres of fog: `mix(SKY_HORIZON, colour, exp(-distance * fog_per_m))`.
pub fn through_fog(color: Vec3, distance_m: f32, fog_per_m: f32) -> Vec3 {
    mix(Vec3::from(SKY_HORIZON), color, libm::expf(-distance_m * fog_per_m))
}

/// WGSL's `mix`.
pub fn mix(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a * (1.0 - t) + b * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_direction_has_unit_length() {
        assert!((Vec3::from(SUN_DIRECTION).length() - 1.0).abs() < 1e-6);
    }

    #[test]
    fn towards_the_sun_is_brightest_and_away_from_it_only_ambient_remains() {
        let sun = Vec3::from(SUN_DIRECTION);
        let lit = light_at(sun);
        let side = light_at(sun.cross(Vec3::Y).normalize());
        let away = light_at(-sun);
        assert!(lit.min_element() > side.max_element() && side.min_element() > away.max_element());
        let up = -sun.y * 0.5 + 0.5;
        let ambient = mix(Vec3::from(GROUND_AMBIENT), Vec3::from(SKY_AMBIENT), up) * EXPOSURE;
        assert!((away - ambient).length() < 1e-6);
    }
}
