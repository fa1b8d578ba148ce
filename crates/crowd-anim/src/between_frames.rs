//! What sampling leaves out: frames are blended linearly, curves turn, and have corners of their own.

use crate::check_input::{check_clip, check_skeleton};
use crate::pose_nodes::{palette_matrix, world_matrices};
use crate::skin::skin;
use crate::{ClipView, Joint, Mat3x4, Result, SampledClip, Skeleton};

/// The largest distance, metres, between a vertex as the clip's curves put it and as the frames of `sampled` do, blended linearly as the player
/// does; and when that is, seconds. Looked at in `looks` places evenly between each two frames: one is right in the middle.
///
/// `positions`, `joint_indices`, `weights`: one per vertex, bind space, metres. What is not finite is infinitely far.
///
/// # Errors
/// As [`crate::sample_clip`].
pub fn between_frames(
    (positions, joint_indices, weights): (&[[f32; 3]], &[[u16; 4]], &[[f32; 4]]),
    (skeleton, joints): (&Skeleton, &[Joint]),
    clip: &ClipView<'_>,
    sampled: &SampledClip,
    looks: u32,
) -> Result<(f32, f32)> {
    check_skeleton(skeleton, joints)?;
    check_clip(skeleton, clip)?;
    let mut farthest = (0.0_f32, 0.0_f32);
    let carried = carried_boxes(positions, joint_indices, weights, joints.len());
    let frames: Vec<&[Mat3x4]> = sampled.palettes.chunks_exact(joints.len().max(1)).collect();
    let step_s = f64::from(sampled.duration_s) / (frames.len().saturating_sub(1)).max(1) as f64;
    for (frame, pair) in frames.windows(2).enumerate() {
        for look in 1..=looks {
            let share = look as f32 / (looks + 1) as f32;
            let time_s = (frame as f64 + f64::from(share)) * step_s;
            let worlds = world_matrices(skeleton, clip, time_s);
            let mut off: Vec<Mat3x4> = joints.iter().map(|joint| palette_matrix(&worlds, joint)).collect();
            for (off, (first, second)) in off.iter_mut().zip(pair[0].iter().zip(pair[1])) {
                for (row, column) in (0..3).flat_map(|row| (0..4).map(move |column| (row, column))) {
                    let (first, second) = (first[row][column], second[row][column]);
                    off[row][column] -= first + (second - first) * share;
                }
            }
            // No vertex is off by more than the corners of the boxes around what its joints carry.
            let reach = |(off, corners): (&Mat3x4, &[[f32; 3]; 8])| {
                corners
                    .iter()
                    .map(|corner| length(skin(*corner, &[0; 4], &WHOLE, std::slice::from_ref(off))))
                    .fold(0.0, f32::max)
            };
            let reachable = off.iter().zip(&carried).filter_map(|(off, carried)| Some(reach((off, carried.as_ref()?))));
            if reachable.fold(0.0, f32::max) * ROUNDING < farthest.0 {
                continue;
            }
            for ((position, joints), weights) in positions.iter().zip(joint_indices).zip(weights) {
                let distance_m = length(skin(*position, joints, weights, &off));
                if distance_m > farthest.0 {
                    farthest = (distance_m, time_s as f32);
                }
            }
        }
    }
    Ok(farthest)
}

/// All of a vertex to the first joint.
const WHOLE: [f32; 4] = [1.0, 0.0, 0.0, 0.0];
/// Weights sum to one but for their rounding.
const ROUNDING: f32 = 1.001;

fn length([x, y, z]: [f32; 3]) -> f32 {
    let length = (x * x + y * y + z * z).sqrt();
    if length.is_finite() { length } else { f32::INFINITY }
}

/// For each joint the corners of the box around the vertices that follow it; nothing where none does.
fn carried_boxes(
    positions: &[[f32; 3]],
    joint_indices: &[[u16; 4]],
    weights: &[[f32; 4]],
    joint_count: usize,
) -> Vec<Option<[[f32; 3]; 8]>> {
    let mut boxes: Vec<Option<([f32; 3], [f32; 3])>> = vec![None; joint_count];
    for ((position, joints), weights) in positions.iter().zip(joint_indices).zip(weights) {
        for (joint, _) in joints.iter().zip(weights).filter(|(_, weight)| **weight != 0.0) {
            let Some(entry) = boxes.get_mut(usize::from(*joint)) else { continue };
            let (min, max) = entry.get_or_insert((*position, *position));
            for axis in 0..3 {
                min[axis] = min[axis].min(position[axis]);
                max[axis] = max[axis].max(position[axis]);
            }
        }
    }
    let corner = |min: [f32; 3], max: [f32; 3], i: usize| {
        std::array::from_fn(|axis| if i >> axis & 1 == 0 { min[axis] } else { max[axis] })
    };
    boxes.into_iter().map(|entry| entry.map(|(min, max)| std::array::from_fn(|i| corner(min, max, i)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Interpolation, Property, TrackView, Trs, sample_frames};
    use glam::{Mat4, Quat, Vec3};

    /// A point at height 1 that goes 1 m to the side and back, the turn at a quarter of the time.
    #[test]
    fn a_corner_between_two_frames_is_seen() {
        let skeleton = Skeleton {
            parents: vec![None],
            rest: vec![Trs { translation: Vec3::ZERO, rotation: Quat::IDENTITY, scale: Vec3::ONE }],
        };
        let joints = [Joint { node: 0, inverse_bind: Mat4::IDENTITY }];
        let track = TrackView {
            node: 0,
            property: Property::Translation,
            interpolation: Interpolation::Linear,
            times: &[0.0, 0.25, 1.0],
            values: &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        };
        let clip = ClipView { name: "nod", tracks: vec![track] };
        let points: (&[[f32; 3]], &[[u16; 4]], &[[f32; 4]]) = (&[[0.0, 1.0, 0.0]], &[[0; 4]], &[[1.0, 0.0, 0.0, 0.0]]);
        let off = |frames, looks| {
            let sampled = sample_frames(&skeleton, &joints, &clip, frames).unwrap();
            between_frames(points, (&skeleton, &joints), &clip, &sampled, looks).unwrap()
        };
        // Four steps have a frame at the corner.
        assert!(off(5, 3).0 < 1e-6);
        // Two steps miss it: two thirds of a metre where it turns.
        let (distance_m, time_s) = off(3, 3);
        assert!((distance_m - 2.0 / 3.0).abs() < 1e-6 && (time_s - 0.25).abs() < 1e-6, "{distance_m} at {time_s}");
        assert_eq!(off(2, 3), (1.0, 0.25));
        // Halfway is not where the corner is.
        assert!((off(2, 1).0 - 2.0 / 3.0).abs() < 1e-6);
    }
}
