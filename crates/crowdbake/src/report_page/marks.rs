//! Dots and lines over a picture.

use crowd_raster::{Target, View};
use glam::{Vec2, Vec3, Vec4};

/// A point of a character, and its colour (sRGB).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dot {
    pub place: [f32; 3],
    pub color: [u8; 4],
}

/// Where a point of the world stands in a picture: pixels right and down, and depth; none behind the camera.
pub(crate) fn project(view: &View, size: [u32; 2], place: [f32; 3]) -> Option<Vec3> {
    let clip: Vec4 = view.clip_from_world * Vec3::from(place).extend(1.0);
    if clip.w.is_nan() || clip.w <= 0.0 {
        return None;
    }
    let (x, y) = (clip.x / clip.w, clip.y / clip.w);
    Some(Vec3::new((x + 1.0) / 2.0 * size[0] as f32, (1.0 - y) / 2.0 * size[1] as f32, clip.z / clip.w))
}

/// Draws the dots that nothing in the picture hides, in their order. `lift_m`: how far towards the eye a dot is moved before
/// its depth is compared, so that its own surface does not swallow it.
pub(crate) fn draw_dots(target: &mut Target, view: &View, dots: &[Dot], radius_px: f32, lift_m: f32) {
    let size = [target.width, target.height];
    for dot in dots {
        let place = Vec3::from(dot.place);
        let lifted = place + (view.eye - place).normalize_or_zero() * lift_m;
        let Some(center) = project(view, size, lifted.to_array()) else { continue };
        if !(center.x >= 0.0 && center.y >= 0.0 && center.x < size[0] as f32 && center.y < size[1] as f32) {
            continue;
        }
        if center.z <= target.depth[center.y as usize * size[0] as usize + center.x as usize] {
            stamp(target, center.truncate(), radius_px, dot.color);
        }
    }
}

/// A line, both ends within or outside the picture; its length is at most what `reach_px` allows.
pub(crate) fn draw_line(target: &mut Target, from: Vec2, to: Vec2, width_px: f32, color: [u8; 4]) {
    let along = to - from;
    let steps = (along.length() / (width_px * 0.5).max(0.25)).ceil().min(65_536.0) as u32;
    for step in 0..=steps {
        let share = if steps == 0 { 0.0 } else { step as f32 / steps as f32 };
        stamp(target, from + along * share, width_px / 2.0, color);
    }
}

/// A disc; its alpha says how much it hides.
fn stamp(target: &mut Target, center: Vec2, radius_px: f32, color: [u8; 4]) {
    let (width, height) = (target.width as f32, target.height as f32);
    let low = (center - radius_px - 0.5).max(Vec2::ZERO);
    let high = (center + radius_px + 0.5).min(Vec2::new(width - 1.0, height - 1.0));
    // A not-a-number compares false and draws nothing.
    if !(low.x <= high.x && low.y <= high.y) {
        return;
    }
    for y in low.y as u32..=high.y as u32 {
        for x in low.x as u32..=high.x as u32 {
            let distance = center.distance(Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
            if distance <= radius_px.max(0.5) {
                let pixel = &mut target.color[(y * target.width + x) as usize];
                let hides = u32::from(color[3]);
                for channel in 0..3 {
                    let mixed = u32::from(pixel[channel]) * (255 - hides) + u32::from(color[channel]) * hides;
                    pixel[channel] = (mixed / 255) as u8;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat4;

    const RED: [u8; 4] = [255, 0, 0, 255];

    #[test]
    fn a_dot_behind_something_is_not_drawn() {
        let view = View { clip_from_world: Mat4::IDENTITY, eye: Vec3::new(0.0, 0.0, -10.0) };
        let dot = Dot { place: [0.0, 0.0, 0.5], color: RED };
        let mut target = Target::new(9, 9, [0, 0, 0, 255]);
        draw_dots(&mut target, &view, &[dot], 1.0, 0.0);
        assert_eq!(target.color[4 * 9 + 4], RED);
        let mut hidden = Target::new(9, 9, [0, 0, 0, 255]);
        hidden.depth.fill(0.25);
        draw_dots(&mut hidden, &view, &[dot], 1.0, 0.0);
        assert_eq!(hidden, Target { depth: hidden.depth.clone(), ..Target::new(9, 9, [0, 0, 0, 255]) });
    }

    #[test]
    fn lines_reach_their_ends_and_stay_inside() {
        let mut target = Target::new(8, 8, [0, 0, 0, 255]);
        draw_line(&mut target, Vec2::new(-20.0, 3.5), Vec2::new(40.0, 3.5), 1.0, RED);
        for x in 0..8 {
            assert_eq!(target.color[3 * 8 + x], RED, "{x}");
        }
        assert!(target.color[..16].iter().all(|pixel| pixel[0] == 0));
        draw_line(&mut target, Vec2::NAN, Vec2::NAN, 1.0, RED);
    }
}
