//! Boxes against the depth pyramid.

use crate::{CrowdData, CullRecord, FrameConfig, InstanceRecord, PyramidConfig, sight};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Pixels that a box is wider than it is: corners snap to a grid, and sines may be off.
const SLACK_PX: f32 = 1.0;
/// Depth that a box is nearer than it is: rounding of the transform and of the interpolation.
const SLACK_DEPTH: f32 = 1e-6;
/// Blocks of the pyramid that a box may span a side.
const MOST_BLOCKS: u32 = 8;

/// How far GPU and CPU may differ in a box's edges, pixels, for boxes whose corners are in the picture, and in its nearest
/// depth: another order of a dot product, a quotient of 2.5 ulp, a sine.
pub const EDGE_BOUNDS: (f32, f32) = (0.05, 2e-6);

/// An instance's box on the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScreenBox {
    /// Left and upper edge, pixels.
    pub least: Vec2,
    /// Right and lower edge, pixels.
    pub most: Vec2,
    /// Nearest depth, 0 to 1.
    pub nearest: f32,
}

/// The box that holds the instance in any pose of its clip: that of the character, cut to the cube around the clip's sphere.
/// `None` when a corner is behind the eye.
pub fn screen_box(
    data: &CrowdData,
    instance: &InstanceRecord,
    config: &FrameConfig,
    pyramid: &PyramidConfig,
) -> Option<ScreenBox> {
    let character = &data.characters[instance.character as usize];
    let sphere = Vec4::from_array(data.clips[instance.clip as usize].sphere);
    let low = Vec3::from_array(character.box_min).max(sphere.truncate() - sphere.w);
    let high = Vec3::from_array(character.box_max).min(sphere.truncate() + sphere.w);
    let size_px = Vec2::new(pyramid.width_px as f32, pyramid.height_px as f32);
    let clip_from_world = Mat4::from_cols_array_2d(&config.clip_from_world);
    let mut all = ScreenBox { least: Vec2::splat(1e9), most: Vec2::splat(-1e9), nearest: 1e9 };
    for c in 0..8 {
        let pick = |axis: usize| if c & (1 << axis) != 0 { high[axis] } else { low[axis] };
        let corner = super::world_from_local(instance, Vec3::new(pick(0), pick(1), pick(2)));
        let clip = clip_from_world * corner.extend(1.0);
        if clip.w.is_nan() || clip.w <= 1e-4 {
            return None;
        }
        let ndc = clip.truncate() / clip.w;
        let px = Vec2::new(ndc.x * 0.5 + 0.5, 0.5 - ndc.y * 0.5) * size_px;
        let depth = if pyramid.reversed != 0 { 1.0 - ndc.z } else { ndc.z };
        all = ScreenBox { least: all.least.min(px), most: all.most.max(px), nearest: all.nearest.min(depth) };
    }
    Some(all)
}

/// Whether everything in the box is behind what the pyramid has there. Errs towards seen alone: the box is taken a pixel wider
/// and a little nearer than it is, and blocks may reach beyond it.
pub fn is_hidden(screen: &ScreenBox, pyramid: &PyramidConfig, farthest: &[f32]) -> bool {
    let size_px = Vec2::new(pyramid.width_px as f32, pyramid.height_px as f32);
    let inside = |p: Vec2| p.clamp(Vec2::ZERO, size_px - 1.0).as_uvec2();
    let (first, last) = (inside(screen.least - SLACK_PX), inside(screen.most + SLACK_PX));
    let fits = |k: &u32| ((last >> (k + 1)) - (first >> (k + 1))).max_element() < MOST_BLOCKS;
    let k = (0..pyramid.level_count).find(fits).unwrap_or(pyramid.level_count - 1);
    let level = &pyramid.levels[k as usize];
    let (begin, end) = (first >> (k + 1), last >> (k + 1));
    let rows = (begin.y..=end.y).map(|y| (level.offset + y * level.width) as usize);
    let blocks = rows.flat_map(|row| &farthest[row + begin.x as usize..=row + end.x as usize]);
    screen.nearest - SLACK_DEPTH > blocks.copied().fold(0.0, f32::max)
}

/// Tests everyone in the frustum against the pyramid of the first phase.
///
/// `farthest`: of `build_pyramid`. `culled`: as `recall_seen` left it; afterwards those are visible who have waited and are not
/// hidden: the second phase. `seen`: words for the next frame.
///
/// The bounds are animated ones ([`screen_box`]): of the clip that plays, not of the bind pose.
/// Nothing visible is missed: who is drawn at a pixel is no farther there than everything in the frame, so no farther than
/// what the first phase drew, and the pyramid has the farthest of that.
///
/// Paper: Haar & Aaltonen 2015. Twin: `shaders/stages/test_occlusion.wgsl`. Equal unless a box's edges or its nearest depth
/// are within [`EDGE_BOUNDS`] of changing the outcome.
pub fn test_occlusion(
    data: &CrowdData,
    instances: &[InstanceRecord],
    pyramid: &PyramidConfig,
    farthest: &[f32],
    culled: &mut [CullRecord],
    seen: &mut [u32],
    config: &FrameConfig,
) {
    seen[0] = instances.len() as u32;
    for (i, (instance, cull)) in instances.iter().zip(culled).enumerate() {
        let was_drawn = cull.visible != 0;
        let waits = !was_drawn && cull.weight > 0.0;
        if !was_drawn && !waits {
            seen[1 + i] = 0;
            continue;
        }
        let screen = screen_box(data, instance, config, pyramid);
        let hidden = screen.is_some_and(|screen| is_hidden(&screen, pyramid, farthest));
        let comes = waits && !hidden;
        cull.visible = if comes { instance.character + 1 } else { 0 };
        let drawn = if was_drawn || comes { sight::DRAWN } else { 0 };
        seen[1 + i] = if hidden { sight::HIDDEN } else { sight::SEEN } | drawn;
    }
}
