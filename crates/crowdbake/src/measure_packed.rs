//! Measures levels of a packed character as its bake did, on the frames that the pack names.

use crate::assemble::px_per_m;
use crate::measure_levels::{LevelMeasure, LevelShape, MeasuredFrames, poked_shares};
use crate::ordered_mesh::OrderedMesh;
use crate::pose::{Mat3x4, pose_positions};
use crate::unpack::Unpacked;
use crowd_lod::Level;
use crowd_pack::{LodRecord, ManifestMeasured};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Points a side and frame that a pack may ask to be measured on: what a bake uses is far below.
pub(crate) const MOST_SAMPLES: u32 = 10_000;

/// How far off a pose may lie, metres: what a bake allows, and room for what storing it rounds.
const MOST_POSED_M: f32 = 1.0e7;

/// What is measured of levels of the order; of stored ones it is what the pack says. `None` where a pack names no frames, or such
/// as cannot be measured.
///
/// The bound is at least that of the next finer quantised level, as in a bake.
pub(crate) fn measure_packed(character: &Unpacked<'_>, levels: &[LodRecord]) -> Vec<Option<ManifestMeasured>> {
    let manifest = character.manifest;
    let refitted = |at: usize| character.discrete_levels()[at].is_refit();
    let discrete =
        manifest.discrete.iter().enumerate().filter(|(at, _)| !refitted(*at)).map(|(_, level)| &level.measured);
    let stored: BTreeMap<(u32, u32), &ManifestMeasured> = manifest
        .measured
        .iter()
        .chain(discrete)
        .map(|measured| ((measured.vertex_count, measured.triangle_count), measured))
        .collect();
    let key = |level: &LodRecord| (level.vertex_count, level.triangle_count);
    let missing: Vec<LodRecord> = levels.iter().filter(|level| !stored.contains_key(&key(level))).copied().collect();
    let asked = !missing.is_empty() && !manifest.measuring.mean_frames.is_empty();
    let measured = if asked { measure_missing(character, &missing) } else { Vec::new() };
    let new: BTreeMap<_, _> = missing.iter().map(key).zip(measured).collect();
    let found = |level: &LodRecord| stored.get(&key(level)).copied().or_else(|| new.get(&key(level))).cloned();
    levels.iter().map(found).collect()
}

fn measure_missing(character: &Unpacked<'_>, levels: &[LodRecord]) -> Vec<ManifestMeasured> {
    let (manifest, measuring) = (character.manifest, &character.manifest.measuring);
    let frames = MeasuredFrames { mean: measuring.mean_frames.clone(), worst: measuring.worst_frames.clone() };
    let (mesh, palettes) = (OrderedMesh::of_pack(character), palettes_of(character, &frames));
    let joint_count = character.joint_count();
    if expect_measurable(character, &palettes).is_err() {
        return Vec::new();
    }
    let samples = measuring.samples_per_frame.min(MOST_SAMPLES);
    let shape = |&LodRecord { vertex_count, triangle_count }: &LodRecord| {
        LevelShape::Shared(mesh.level_triangles(&Level { vertex_count, triangle_count, error_m: 0.0 }))
    };
    let shapes: Vec<LevelShape> = levels.iter().map(shape).collect();
    let errors = LevelMeasure::new(&mesh, &frames, &palettes, joint_count, samples).measure(&shapes);
    let poked = poked_shares(&mesh, &shapes, &frames, &palettes, joint_count);
    let height_m = character.record.height_m;
    let px_per_m = px_per_m(height_m, character.record.sphere[3]);
    let measured = |((level, error), poked_share): ((&LodRecord, crowd_lod::SurfaceError), f32)| {
        let finer = manifest.measured.iter().find(|finer| finer.triangle_count >= level.triangle_count);
        let bound_m = error.bound_m.max(finer.map_or(0.0, |finer| finer.bound_m));
        let (max_clip, max_frame) = clip_of_frame(character, error.max_frame);
        ManifestMeasured {
            vertex_count: level.vertex_count,
            triangle_count: level.triangle_count,
            rms_m: error.rms_m,
            max_m: error.max_m,
            max_clip,
            max_frame,
            bound_m,
            uv_drift_p95_texels: error.uv_drift_p95_texels,
            normal_mean_deg: error.normal_mean_deg,
            bound_px: bound_m * px_per_m,
            poked_share,
        }
    };
    levels.iter().zip(errors).zip(poked).map(measured).collect()
}

/// Clip, and frame within it, of a frame counted over all clips.
fn clip_of_frame(character: &Unpacked<'_>, frame: u32) -> (u32, u32) {
    clip_at(character.clips.iter().map(|clip| clip.frame_count), frame)
}

/// A frame of a clip, counted over all clips.
pub(crate) fn frame_of_clip(character: &Unpacked<'_>, clip: u32, frame: u32) -> u32 {
    frame_at(character.clips.iter().map(|clip| clip.frame_count), clip, frame)
}

fn clip_at(frame_counts: impl Iterator<Item = u32>, mut frame: u32) -> (u32, u32) {
    for (index, count) in frame_counts.enumerate() {
        if frame < count {
            return (index as u32, frame);
        }
        frame -= count;
    }
    (0, 0)
}

fn frame_at(frame_counts: impl Iterator<Item = u32>, clip: u32, frame: u32) -> u32 {
    frame_counts.take(clip as usize).sum::<u32>() + frame
}

/// Palettes of the frames measured, in their order.
pub(crate) fn palettes_of(character: &Unpacked<'_>, frames: &MeasuredFrames) -> Vec<Mat3x4> {
    let joint_count = character.joint_count();
    let wanted: BTreeSet<usize> = frames.all().map(|frame| frame as usize).collect();
    let (mut by_frame, mut first) = (BTreeMap::new(), 0);
    for (index, clip) in character.clips.iter().enumerate() {
        let end = first + clip.frame_count as usize;
        if wanted.range(first..end).next().is_some() {
            let all = character.palettes(index);
            for &frame in wanted.range(first..end) {
                by_frame.insert(frame, all[(frame - first) * joint_count..][..joint_count].to_vec());
            }
        }
        first = end;
    }
    frames.all().flat_map(|frame| by_frame.get(&(frame as usize)).cloned().unwrap_or_default()).collect()
}

/// Refuses poses so far off that distances are no numbers any more: a bake writes none, but a pack's matrices may say so. `palettes`: of frames,
/// one after the other.
pub(crate) fn expect_measurable(character: &Unpacked<'_>, palettes: &[Mat3x4]) -> Result<(), String> {
    let is_near = |p: &[f32; 3]| p.iter().all(|c| c.abs() <= MOST_POSED_M);
    palettes.par_chunks_exact(character.joint_count().max(1)).try_for_each(|palette| {
        let posed = pose_positions(&character.positions, &character.joints, &character.weights, palette);
        match posed.iter().position(|p| !is_near(p)) {
            None => Ok(()),
            Some(vertex) => Err(format!(
                "a frame that the levels are measured in has vertex {vertex} at {:?}, beyond {MOST_POSED_M} m",
                posed[vertex]
            )),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_found_again_by_its_clip() {
        let counts = || [3, 1, 4].into_iter();
        let clips: Vec<(u32, u32)> = (0..8).map(|frame| clip_at(counts(), frame)).collect();
        assert_eq!(clips, [(0, 0), (0, 1), (0, 2), (1, 0), (2, 0), (2, 1), (2, 2), (2, 3)]);
        for (frame, &(clip, within)) in clips.iter().enumerate() {
            assert_eq!(frame_at(counts(), clip, within), frame as u32);
        }
    }
}
