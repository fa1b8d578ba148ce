//! A clip as poses at even times, with the root's travel and the loop's gap.

use crate::check_input::{check_clip, check_skeleton, expect};
use crate::pose_nodes::{palette_matrix, to_rows, world_matrices};
use crate::{ClipView, Joint, Property, Result, RootMotion, SampledClip, Skeleton};
use glam::{DMat4, DVec3};

/// Frames of a clip, at most: 36 minutes at 30 frames a second.
pub const MAX_FRAMES: u32 = 65_536;
/// Matrices of a clip, at most: 1.9 GB in both layouts.
pub const MAX_MATRICES: u64 = 1 << 24;
/// A clip this much longer than a whole number of frames gets no frame more: key times are rounded to `f32`.
pub const FRAME_TOLERANCE: f64 = 1e-3;

/// Samples a clip at about `fps` frames a second.
///
/// Frames: `n = max(1, ceil(duration * fps)) + 1` (1 for a duration of 0), spread evenly so that the last one falls on the
/// clip's end exactly; a closed loop thus ends with the pose it began with. A thousandth of a frame is forgiven before
/// rounding up. Duration: the largest key time of any track.
///
/// The order of the arithmetic is fixed and in `f64`, so that the same clip gives the same bytes on every machine.
///
/// # Errors
/// [`crate::Error::Parameter`] when `fps` is not within 1..=240, an index points outside, keys and values do not fit, a
/// number is not finite (given or computed) or the clip has more than [`MAX_FRAMES`] or [`MAX_MATRICES`].
pub fn sample_clip(skeleton: &Skeleton, joints: &[Joint], clip: &ClipView<'_>, fps: f32) -> Result<SampledClip> {
    let rate = || "frames a second".to_owned();
    expect((1.0..=240.0).contains(&fps), rate, || fps.to_string(), || "1 to 240".to_owned())?;
    check_skeleton(skeleton, joints)?;
    check_clip(skeleton, clip)?;
    let frame_count = count_frames(clip, duration_of(clip), fps, joints.len())?;
    sample(skeleton, joints, clip, frame_count)
}

/// Samples a clip at that many frames, spread evenly from its beginning to its end: one for a clip without duration, at least two for others.
///
/// # Errors
/// As [`sample_clip`].
pub fn sample_frames(
    skeleton: &Skeleton,
    joints: &[Joint],
    clip: &ClipView<'_>,
    frame_count: u32,
) -> Result<SampledClip> {
    check_skeleton(skeleton, joints)?;
    check_clip(skeleton, clip)?;
    let allowed = if duration_of(clip) > 0.0 { 2..=MAX_FRAMES } else { 1..=1 };
    let what = || format!("clip `{}`: frames", clip.name.escape_debug());
    expect(allowed.contains(&frame_count), what, || frame_count.to_string(), || format!("{allowed:?}"))?;
    check_matrices(clip, frame_count, joints.len())?;
    sample(skeleton, joints, clip, frame_count)
}

/// The largest key time of any track.
pub(crate) fn duration_of(clip: &ClipView<'_>) -> f32 {
    clip.tracks.iter().filter_map(|track| track.times.last()).fold(0.0_f32, |a, &t| a.max(t))
}

/// The input was checked.
fn sample(skeleton: &Skeleton, joints: &[Joint], clip: &ClipView<'_>, frame_count: u32) -> Result<SampledClip> {
    let duration_s = duration_of(clip);
    let mut palettes = Vec::with_capacity(frame_count as usize * joints.len());
    let mut worlds = Vec::with_capacity(palettes.capacity());
    let mut ends: [Vec<DMat4>; 2] = [Vec::new(), Vec::new()];
    for frame in 0..frame_count {
        let time_s = f64::from(duration_s) * f64::from(frame) / f64::from((frame_count - 1).max(1));
        let nodes = world_matrices(skeleton, clip, time_s);
        palettes.extend(joints.iter().map(|joint| palette_matrix(&nodes, joint)));
        worlds.extend(joints.iter().map(|joint| to_rows(nodes[joint.node as usize])));
        if frame == 0 {
            ends[0].clone_from(&nodes);
        }
        ends[1] = nodes;
    }
    let finite = palettes.iter().flatten().chain(worlds.iter().flatten()).flatten().all(|value| value.is_finite());
    let what = || format!("clip `{}`: matrices", clip.name.escape_debug());
    expect(finite, what, || "numbers too large".to_owned(), || "finite numbers".to_owned())?;

    let root_motion = measure_root_motion(skeleton, clip, &ends);
    let loop_gap_m = measure_loop_gap(joints, &ends, root_motion);
    let name = clip.name.to_owned();
    Ok(SampledClip { name, duration_s, frame_count, palettes, worlds, root_motion, loop_gap_m })
}

/// The pose at rest as a clip of one frame, for characters without animations. It is called `rest`.
///
/// # Errors
/// As [`sample_clip`].
pub fn rest_clip(skeleton: &Skeleton, joints: &[Joint]) -> Result<SampledClip> {
    sample_clip(skeleton, joints, &ClipView { name: "rest", tracks: Vec::new() }, 1.0)
}

fn count_frames(clip: &ClipView<'_>, duration_s: f32, fps: f32, joint_count: usize) -> Result<u32> {
    let steps = (f64::from(duration_s) * f64::from(fps) - FRAME_TOLERANCE).ceil().max(1.0);
    let frames = if duration_s > 0.0 { steps + 1.0 } else { 1.0 };
    let what = |field: &str| format!("clip `{}`: {field}", clip.name.escape_debug());
    let allowed = || format!("at most {MAX_FRAMES}: leave the clip out, or sample fewer frames a second");
    expect(frames <= f64::from(MAX_FRAMES), || what("frames"), || frames.to_string(), allowed)?;
    check_matrices(clip, frames as u32, joint_count)?;
    Ok(frames as u32)
}

fn check_matrices(clip: &ClipView<'_>, frame_count: u32, joint_count: usize) -> Result<()> {
    let matrices = u64::from(frame_count) * joint_count as u64;
    let what = || format!("clip `{}`: matrices", clip.name.escape_debug());
    expect(matrices <= MAX_MATRICES, what, || matrices.to_string(), || format!("at most {MAX_MATRICES}"))
}

/// The first node, from the root down, with a translation track, and where it goes.
fn measure_root_motion(skeleton: &Skeleton, clip: &ClipView<'_>, ends: &[Vec<DMat4>; 2]) -> RootMotion {
    let moved = clip.tracks.iter().filter(|track| track.property == Property::Translation);
    // Parents come first.
    let mut depths = vec![0_u32; skeleton.parents.len()];
    for (node, parent) in skeleton.parents.iter().enumerate() {
        depths[node] = parent.map_or(0, |parent| depths[parent as usize] + 1);
    }
    let Some(node) = moved.map(|track| track.node).min_by_key(|&node| (depths[node as usize], node)) else {
        return RootMotion::default();
    };
    let [first, last] = ends.each_ref().map(|nodes| origin(&nodes[node as usize]));
    let travel = last - first;
    RootMotion { node: Some(node), displacement_m: travel.as_vec3().to_array() }
}

fn measure_loop_gap(joints: &[Joint], ends: &[Vec<DMat4>; 2], root_motion: RootMotion) -> f32 {
    let travel = DVec3::from(root_motion.displacement_m.map(f64::from));
    let gap = |joint: &Joint| {
        let [first, last] = ends.each_ref().map(|nodes| origin(&nodes[joint.node as usize]));
        (last - first - travel).length()
    };
    joints.iter().map(gap).fold(0.0, f64::max) as f32
}

fn origin(world: &DMat4) -> DVec3 {
    world.w_axis.truncate()
}

#[cfg(test)]
mod tests;
