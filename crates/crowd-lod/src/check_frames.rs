//! Measures levels on all frames, to see whether the chosen ones stood for the rest.
//!
//! A point of full detail is tied to the triangle of the level that is closest to it at rest, and its distance to that
//! triangle is followed through every frame: an upper bound of the distance to the level, at the price of posing six
//! vertices a point and frame. No search, and no quadric: what the collapse believed plays no part.

use crate::closest::{ClosestTriangles, triangle_distance_squared};
use crate::frames::ChosenFrames;
use crate::measure::{Sample, place_of, spread_samples};
use crate::quadrics::pose_position;
use crate::{CollapseOrder, FrameCheck, LodMesh, LodPoses, reform};
use rayon::prelude::*;

/// Shares of the triangles that are measured.
const CHECKED_SHARES: [f64; 2] = [0.25, 0.05];
/// Points measured on each level.
const CHECKED_POINTS: usize = 400;
/// The same, at least, and points times frames beyond which there are fewer.
const LEAST_POINTS: usize = 64;
const CHECKED_PLACES: usize = 1 << 21;
/// What the mean over the chosen frames may be off the mean over all, as a share of it.
pub(crate) const ALLOWED_DEVIATION: f32 = 0.03;
/// How much worse the worst of all frames may be than the worst of the chosen ones.
pub(crate) const ALLOWED_WORST: f32 = 1.1;
/// Frames added when the check fails: one block of lanes.
const ADDED_FRAMES: usize = 8;

/// Error of the checked levels in every frame.
pub(crate) struct FrameErrors {
    /// `[level][frame]`: mean squared distance, m².
    by_level: Vec<Vec<f64>>,
}

/// Measures the checked levels of `order` on all frames of `poses`.
pub(crate) fn measure_all_frames(mesh: &LodMesh<'_>, poses: &LodPoses<'_>, order: &CollapseOrder) -> FrameErrors {
    let full_count = order.levels.last().map_or(0, |level| level.triangle_count);
    let mut levels: Vec<usize> = CHECKED_SHARES
        .iter()
        .map(|share| {
            let wanted = share * f64::from(full_count);
            order.levels.partition_point(|level| f64::from(level.triangle_count) <= wanted).max(1) - 1
        })
        .collect();
    levels.dedup();
    let errors = |&level: &usize| errors_of_level(mesh, poses, order, level);
    FrameErrors { by_level: levels.iter().map(errors).collect() }
}

fn errors_of_level(mesh: &LodMesh<'_>, poses: &LodPoses<'_>, order: &CollapseOrder, level: usize) -> Vec<f64> {
    let level = order.levels[level];
    let input = |t: &[u32; 3]| t.map(|v| order.vertex_source[v as usize]);
    let full: Vec<[u32; 3]> = order.triangles.iter().map(input).collect();
    let reformed = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
    let coarse: Vec<[u32; 3]> = reformed.iter().map(input).collect();
    let mut tree = ClosestTriangles::new(mesh.positions, &coarse);
    tree.refit(mesh.positions, &coarse);

    let count = (CHECKED_PLACES / poses.frame_weights.len()).clamp(LEAST_POINTS, CHECKED_POINTS);
    let samples = spread_samples(mesh.positions, &full, count as u32);
    let tie = |sample: &Sample| {
        let place = place_of(sample, full[sample.triangle as usize].map(|v| mesh.positions[v as usize]));
        tree.closest(place, mesh.positions, &coarse, u32::MAX).map(|(triangle, _)| (*sample, coarse[triangle as usize]))
    };
    let tied: Vec<(Sample, [u32; 3])> = samples.par_iter().filter_map(tie).collect();
    let error = |frame: usize| {
        let palette = &poses.palettes[frame * poses.joint_count..][..poses.joint_count];
        let pose = |v: u32| {
            let v = v as usize;
            pose_position(mesh.positions[v], mesh.joints[v], mesh.weights[v], palette)
        };
        let squared = |(sample, corners): &(Sample, [u32; 3])| {
            let place = place_of(sample, full[sample.triangle as usize].map(pose));
            f64::from(triangle_distance_squared(place, corners.map(pose)))
        };
        tied.iter().map(squared).sum::<f64>() / tied.len().max(1) as f64
    };
    (0..poses.frame_weights.len()).into_par_iter().map(error).collect()
}

impl FrameErrors {
    /// Compares the chosen frames with all.
    pub fn check(&self, poses: &LodPoses<'_>, chosen: &ChosenFrames<'_>) -> FrameCheck {
        let (mut deviation, mut worst_ratio) = (0.0_f32, 1.0_f32);
        for errors in &self.by_level {
            let all = weighted_mean(errors.iter().copied(), poses.frame_weights);
            let of_chosen = || chosen.frames.iter().map(|&frame| errors[frame as usize]);
            let some = weighted_mean(of_chosen(), chosen.poses().frame_weights);
            let worst = errors.iter().copied().fold(0.0, f64::max);
            let worst_chosen = of_chosen().fold(0.0, f64::max);
            // Nothing to be off: a flat or undamaged level.
            if all > 0.0 && worst_chosen > 0.0 {
                deviation = deviation.max(((some / all).sqrt() - 1.0).abs() as f32);
                worst_ratio = worst_ratio.max((worst / worst_chosen).sqrt() as f32);
            } else if worst > 0.0 {
                deviation = deviation.max(1.0);
            }
        }
        FrameCheck { deviation, worst_ratio, holds: deviation <= ALLOWED_DEVIATION && worst_ratio <= ALLOWED_WORST }
    }

    /// The frames whose error the chosen ones tell least about, by weight, and the worst frame of each level.
    pub fn frames_to_add(&self, poses: &LodPoses<'_>, chosen: &ChosenFrames<'_>) -> Vec<u32> {
        let mut missed: Vec<(f64, u32)> =
            (0..poses.frame_weights.len() as u32).map(|frame| (self.missed(poses, chosen, frame), frame)).collect();
        missed.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let worst = self.by_level.iter().map(|errors| {
            let by_error = |&a: &usize, &b: &usize| errors[a].total_cmp(&errors[b]).then(b.cmp(&a));
            (0..errors.len()).max_by(by_error).expect("there is at least one frame") as u32
        });
        let mut added: Vec<u32> = Vec::new();
        for frame in worst.chain(missed.into_iter().filter(|m| m.0 > 0.0).map(|m| m.1)) {
            if added.len() < ADDED_FRAMES && !added.contains(&frame) && !chosen.frames.contains(&frame) {
                added.push(frame);
            }
        }
        added
    }

    /// Mean over all frames of each level's squared error, m².
    #[cfg(test)]
    pub fn mean_squares(&self, poses: &LodPoses<'_>) -> Vec<f64> {
        self.by_level.iter().map(|errors| weighted_mean(errors.iter().copied(), poses.frame_weights)).collect()
    }

    /// How far a frame's error lies off that of the frame which stands for it: its share in the mean of each level.
    fn missed(&self, poses: &LodPoses<'_>, chosen: &ChosenFrames<'_>, frame: u32) -> f64 {
        let stand_in = chosen.frames[chosen.stand_ins[frame as usize] as usize] as usize;
        let off = |errors: &Vec<f64>| {
            let all = weighted_mean(errors.iter().copied(), poses.frame_weights);
            if all > 0.0 { (errors[frame as usize] - errors[stand_in]).abs() / all } else { 0.0 }
        };
        f64::from(poses.frame_weights[frame as usize]) * self.by_level.iter().map(off).sum::<f64>()
    }
}

fn weighted_mean(values: impl Iterator<Item = f64>, weights: &[f32]) -> f64 {
    let (mut sum, mut total) = (0.0, 0.0);
    for (value, &weight) in values.zip(weights) {
        sum += value * f64::from(weight);
        total += f64::from(weight);
    }
    if total > 0.0 { sum / total } else { 0.0 }
}
