//! Fog over a picture that is drawn: how far away a pixel is follows from its depth.

use crate::ground::{FARTHEST, Rays, ndc_of_pixel};
use crate::light;
use crate::srgb::{decode_table, encode_rgb};
use crate::{Target, View};
use glam::Vec3;
use rayon::prelude::*;

/// Mixes the horizon's colour into every pixel by its distance: after d metres `exp(-d * fog_per_m)` of a colour is left. Where nothing
/// is drawn (depth 1) it is the sky, seen through a layer of [`light::FOG_LAYER_M`]. Call it last. Nothing without fog or perspective.
///
/// Shaders do the same before they encode a colour, so a picture of theirs is a step of 255 apart here and there.
pub fn draw_fog(target: &mut Target, view: &View, fog_per_m: f32) {
    let Some(rays) = Rays::new(view).filter(|_| fog_per_m > 0.0) else { return };
    let (width, height) = (target.width, target.height);
    let stride = width.max(1) as usize;
    let rows = target.color.par_chunks_mut(stride).zip(target.depth.par_chunks(stride)).enumerate();
    rows.for_each(|(y, (colors, depths))| {
        for (x, (color, depth)) in colors.iter_mut().zip(depths).enumerate() {
            let direction = rays.direction(ndc_of_pixel(x as u32, y as u32, width, height));
            let distance_m = distance_at(view, direction, *depth);
            let [r, g, b, _] = color.map(|code| decode_table()[usize::from(code)]);
            *color = encode_rgb(light::through_fog(Vec3::new(r, g, b), distance_m, fog_per_m));
        }
    });
}

/// Metres of fog before what is seen along a ray of [`Rays`], whose clip w is the distance in its own length.
fn distance_at(view: &View, direction: Vec3, depth: f32) -> f32 {
    let up = direction.normalize_or_zero().y.clamp(0.0, 1.0);
    if depth >= 1.0 {
        return light::FOG_LAYER_M / up.max(1e-4);
    }
    if depth >= FARTHEST {
        // Ground behind the far plane.
        let t = (light::GROUND_Y_M - view.eye.y) / direction.y;
        return t.max(0.0) * direction.length();
    }
    // Clip z along the ray is a + t * b.
    let row = view.clip_from_world.row(2);
    let (a, b) = (row.dot(view.eye.extend(1.0)), row.truncate().dot(direction));
    let t = a / (depth - b);
    if t.is_finite() { t.max(0.0) * direction.length() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{draw_ground, draw_sky};

    fn view() -> View {
        let camera =
            glam::camera::rh::view::look_at_mat4(Vec3::new(0.0, 3.0, 0.0), Vec3::new(0.0, 1.0, -10.0), Vec3::Y);
        let clip = glam::camera::rh::proj::directx::perspective(1.0, 4.0 / 3.0, 0.1, 300.0);
        View { clip_from_world: clip * camera, eye: Vec3::new(0.0, 3.0, 0.0) }
    }

    fn picture(fog_per_m: f32) -> Target {
        let mut target = Target::new(40, 30, [0, 0, 0, 255]);
        draw_sky(&mut target, &view());
        draw_ground(&mut target, &view());
        draw_fog(&mut target, &view(), fog_per_m);
        target
    }

    #[test]
    fn distances_are_those_of_the_ground() {
        let target = picture(0.0);
        let rays = Rays::new(&view()).expect("perspective");
        let mut compared = 0;
        for (i, depth) in target.depth.iter().enumerate().filter(|(_, depth)| **depth < 1.0) {
            let direction = rays.direction(ndc_of_pixel(i as u32 % 40, i as u32 / 40, 40, 30));
            let along = (light::GROUND_Y_M - 3.0) / direction.y * direction.length();
            let found = distance_at(&view(), direction, *depth);
            assert!((found / along - 1.0).abs() < 0.02, "{found} for {along}");
            compared += 1;
        }
        assert!(compared > 300, "{compared}");
    }

    #[test]
    fn more_fog_brings_all_nearer_to_the_horizon_and_none_changes_nothing() {
        let horizon = encode_rgb(Vec3::from(light::SKY_HORIZON));
        let apart = |target: &Target| {
            let off = |a: &[u8; 4]| a.iter().zip(horizon).map(|(a, b)| u64::from(a.abs_diff(b))).sum::<u64>();
            target.color.iter().map(off).sum::<u64>()
        };
        let sums = [0.0, 0.01, 0.05, 10.0].map(|fog| apart(&picture(fog)));
        assert!(sums[0] > sums[1] && sums[1] > sums[2] && sums[2] > sums[3], "{sums:?}");
        assert!(picture(10.0).color.iter().all(|pixel| *pixel == horizon));
        let view = View { clip_from_world: glam::Mat4::ZERO, eye: Vec3::ZERO };
        let mut flat = Target::new(3, 2, [1, 2, 3, 255]);
        draw_fog(&mut flat, &view, 1.0);
        assert_eq!(flat, Target::new(3, 2, [1, 2, 3, 255]));
    }
}
