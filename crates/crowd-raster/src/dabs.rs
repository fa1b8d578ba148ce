//! Points of a surface, a pixel each: what a GPU's point list draws.

use crate::light::light_at;
use crate::srgb::encode_rgb;
use crate::{Target, View};
use glam::Vec3;

/// A point of a surface in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dab {
    /// World, metres.
    pub position: Vec3,
    /// World, unit.
    pub normal: Vec3,
    /// Linear base colour.
    pub color: Vec3,
    /// Light does not change it.
    pub is_unlit: bool,
    /// The back is seen, too.
    pub is_double_sided: bool,
}

/// Draws points in order, squares of `side` pixels (1: the pixel it falls into), depth-tested. Points turned away are left out, or
/// turned round.
pub fn draw_dabs(target: &mut Target, view: &View, dabs: &[Dab], side: u32) {
    let size = [target.width as f32, target.height as f32];
    let half = 0.5 * side as f32;
    for dab in dabs {
        let is_away = dab.normal.dot(view.eye - dab.position) < 0.0;
        let clip = view.clip_from_world * dab.position.extend(1.0);
        let is_inside = clip.w > 0.0 && clip.z >= 0.0 && clip.z <= clip.w;
        if !is_inside || (is_away && !dab.is_double_sided) {
            continue;
        }
        let [x, y] = [(0.5 + 0.5 * clip.x / clip.w) * size[0], (0.5 - 0.5 * clip.y / clip.w) * size[1]];
        if !(x >= 0.0 && x < size[0] && y >= 0.0 && y < size[1]) {
            continue;
        }
        let depth = clip.z / clip.w;
        let normal = if is_away { -dab.normal } else { dab.normal };
        let light = if dab.is_unlit { Vec3::ONE } else { light_at(normal) };
        let color = encode_rgb(dab.color * light);
        // Pixels whose middles lie in the square.
        let span = |at: f32, end: u32| {
            let first = (at - half + 0.5).floor() as i64;
            first.max(0) as usize..(first + i64::from(side)).clamp(0, i64::from(end)) as usize
        };
        for row in span(y, target.height) {
            for column in span(x, target.width) {
                let pixel = row * target.width as usize + column;
                if depth < target.depth[pixel] {
                    target.depth[pixel] = depth;
                    target.color[pixel] = color;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat4;

    fn dab(position: Vec3, color: Vec3) -> Dab {
        Dab { position, normal: Vec3::Z, color, is_unlit: true, is_double_sided: false }
    }

    /// Four by two pixels; clip space is the world's.
    fn drawn(dabs: &[Dab], side: u32) -> Target {
        let mut target = Target::new(4, 2, [9, 9, 9, 255]);
        draw_dabs(&mut target, &View { clip_from_world: Mat4::IDENTITY, eye: Vec3::new(0.0, 0.0, 9.0) }, dabs, side);
        target
    }

    #[test]
    fn a_large_dab_covers_the_pixels_around_and_ends_at_the_edge() {
        // At pixel 0.5, 0.5: a square of 3 pixels reaches one pixel over the left and the upper edge.
        let target = drawn(&[dab(Vec3::new(-0.75, 0.5, 0.5), Vec3::ONE)], 3);
        let white: Vec<usize> = (0..8).filter(|pixel| target.color[*pixel] == [255; 4]).collect();
        assert_eq!(white, [0, 1, 4, 5]);
    }

    #[test]
    fn a_dab_covers_the_pixel_it_falls_into_and_the_nearer_one_wins() {
        let place = Vec3::new(0.25, 0.5, 0.5);
        let target = drawn(&[dab(place, Vec3::X), dab(place - 0.1 * Vec3::Z, Vec3::Y), dab(place, Vec3::Z)], 1);
        let mut expected = [[9, 9, 9, 255]; 8];
        expected[2] = [0, 255, 0, 255];
        assert_eq!(target.color, expected);
        assert_eq!(target.depth[2], 0.4);
    }

    #[test]
    fn backs_and_what_is_outside_are_left_out() {
        let away = Dab { normal: -Vec3::Z, ..dab(Vec3::new(0.0, 0.0, 0.5), Vec3::ONE) };
        let outside = [Vec3::new(1.5, 0.0, 0.5), Vec3::new(0.0, 0.0, -0.5), Vec3::splat(f32::NAN)];
        let dabs: Vec<Dab> = outside.into_iter().map(|place| dab(place, Vec3::ONE)).chain([away]).collect();
        assert_eq!(drawn(&dabs, 1), Target::new(4, 2, [9, 9, 9, 255]));
        assert_ne!(drawn(&[Dab { is_double_sided: true, ..away }], 1), Target::new(4, 2, [9, 9, 9, 255]));
    }
}
