//! How a character's animation is stored: the smallest storage and the fewest frames with which no vertex goes astray.

use crate::error::Cause;
use crate::sample::key_times;
use crate::views::{self, QuantizedMesh};
use crowd_anim::{ClipView, Joint, SampledClip, Skeleton, frames_apart, key_steps, sample_frames};
use crowd_pack::{AnimationLayout, JointStorage, SPLIT_JOINT_BYTES, Texel, store_frame, stored_frames};
use crowd_source::{RawCharacter, RawClip, RawInterpolation, Warning};
use rayon::prelude::*;
use std::collections::BTreeSet;

/// Share of the height that vertices may be off by, unless told otherwise: goal of the crowd's memory, and less than a pixel where the
/// character is a thousand pixels high.
pub const DEFAULT_ERROR_SHARE: f32 = 0.001;

/// How someone wants animation stored.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StorageAsked {
    /// `None` for the smallest that stays within the error.
    pub storage: Option<JointStorage>,
    /// What vertices may be off by in any frame or between, as a share of the height at rest. 0 keeps every frame as it was sampled.
    pub error_share: f32,
    /// Layout of the pack. The papers' has full floats of every frame, whatever the others say.
    pub layout: AnimationLayout,
}

impl Default for StorageAsked {
    fn default() -> Self {
        Self { storage: None, error_share: DEFAULT_ERROR_SHARE, layout: AnimationLayout::default() }
    }
}

impl StorageAsked {
    /// Every frame as it was sampled.
    pub fn exact() -> Self {
        Self { storage: Some(JointStorage::F32), error_share: 0.0, ..Self::default() }
    }

    /// The papers' layout.
    pub fn papers() -> Self {
        Self { layout: AnimationLayout::Split4x4, ..Self::exact() }
    }
}

/// A character's clips as they are stored.
#[derive(Debug, Clone, Default)]
pub struct StoredAnimation {
    /// Layout of the pack.
    pub layout: AnimationLayout,
    /// How joints are stored.
    pub storage: JointStorage,
    /// The clips, matrices as a reader gets them.
    pub clips: Vec<SampledClip>,
    /// Texels of each clip.
    pub texels: Vec<Vec<Texel>>,
    /// No vertex is farther than this from where the clips as sampled put it, metres.
    pub error_m: f32,
    /// Where the sampled frames are farthest from the clips' curves: between frames, which are blended linearly.
    pub between: BetweenFrames,
    /// What was allowed, metres.
    pub allowed_m: f32,
    /// Frames as sampled, over all clips.
    pub sampled_frames: u32,
    /// Smaller storages that were tried, how far a vertex would be off, and in which clip.
    pub passed_over: Vec<(JointStorage, f32, String)>,
}

/// How far a vertex gets between two sampled frames from where its clip's curves put it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BetweenFrames {
    /// Metres; 0 where nothing moves.
    pub distance_m: f32,
    /// In this clip.
    pub clip: String,
    /// At this time, seconds.
    pub time_s: f32,
}

impl StoredAnimation {
    /// Bytes of all clips in the pack.
    pub fn bytes(&self, joint_count: usize) -> u64 {
        animation_bytes(self.layout, self.storage, joint_count as u32, self.clips.iter().map(|clip| clip.frame_count))
    }

    /// How joints are stored, in a word: `f32`, `f16` or `quantized`; `4x4` in the papers' layout.
    pub fn storage_name(&self) -> &'static str {
        storage_name(self.layout, self.storage)
    }

    /// Bytes that the papers' layout takes: 64 a joint and sampled frame (Dong 2019 §5.1).
    pub fn papers_bytes(&self, joint_count: usize) -> u64 {
        u64::from(self.sampled_frames) * joint_count as u64 * u64::from(SPLIT_JOINT_BYTES)
    }

    /// A warning where a storage was asked for that is off by more than allowed, or where the smallest would have been.
    pub fn warning(&self) -> Option<Warning> {
        let (allowed, name) = (self.allowed_m * 1e3, self.storage.name());
        let message = match self.passed_over.first() {
            _ if self.error_m > self.allowed_m => {
                format!("as {name} vertices are off by {:.2} mm, allowed {allowed:.2}", self.error_m * 1e3)
            }
            Some((storage, error_m, clip)) => format!(
                "as {} a vertex would be off by {:.2} mm in clip `{}`, allowed {allowed:.2}; stored as {name} (joints that shear, mirror or go far need more room)",
                storage.name(),
                error_m * 1e3,
                clip.escape_debug(),
            ),
            None => return None,
        };
        Some(Warning { code: "animation-storage", place: "animation".to_owned(), count: 1, message })
    }
}

/// A storage in a word: `f32`, `f16` or `quantized`; `4x4` for the papers' layout.
pub(crate) fn storage_name(layout: AnimationLayout, storage: JointStorage) -> &'static str {
    match layout {
        AnimationLayout::Premultiplied3x4 => storage.name(),
        AnimationLayout::Split4x4 => "4x4",
    }
}

/// Bytes that clips of so many frames take in a pack.
pub(crate) fn animation_bytes(
    layout: AnimationLayout,
    storage: JointStorage,
    joint_count: u32,
    frame_counts: impl Iterator<Item = u32>,
) -> u64 {
    let frame_bytes = u64::from(layout.frame_texels(storage, joint_count)) * size_of::<Texel>() as u64;
    frame_counts.map(|frames| u64::from(frames) * frame_bytes).sum()
}

/// What is measured on: every vertex that differs from others in place, joints or weights.
struct Points {
    positions: Vec<[f32; 3]>,
    joints: Vec<[u16; 4]>,
    weights: Vec<[f32; 4]>,
    joint_count: usize,
}

impl Points {
    fn of(mesh: &QuantizedMesh, joint_count: usize) -> Self {
        let mut seen = BTreeSet::new();
        let mut points = Self { positions: Vec::new(), joints: Vec::new(), weights: Vec::new(), joint_count };
        for (vertex, record) in mesh.records.iter().enumerate() {
            if seen.insert((record.position.map(f32::to_bits), record.joints, record.weights)) {
                points.positions.push(mesh.positions[vertex]);
                points.joints.push(mesh.joints[vertex]);
                points.weights.push(mesh.weights[vertex]);
            }
        }
        points
    }

    fn apart(&self, reference: &SampledClip, stored: &SampledClip, enough: f32) -> f32 {
        let (a, b) = (&reference.palettes, &stored.palettes);
        frames_apart(&self.positions, &self.joints, &self.weights, a, b, self.joint_count, enough)
    }
}

/// Stores the clips of a character. `clips`: as sampled; `height_m`: at rest.
///
/// The storage is one for the whole character: the smallest with which every clip stays within the error when all of its frames are kept, or
/// the one asked for. Then each clip keeps as few frames as stay within, evenly spread, sampled from its curves.
///
/// # Errors
/// What sampling refuses.
pub fn store_animation(
    raw: &RawCharacter,
    mesh: &QuantizedMesh,
    clips: &[SampledClip],
    height_m: f32,
    asked: &StorageAsked,
) -> Result<StoredAnimation, Cause> {
    let points = Points::of(mesh, raw.joints.len());
    let allowed_m = height_m * asked.error_share;
    let mut stored = StoredAnimation {
        allowed_m,
        layout: asked.layout,
        sampled_frames: clips.iter().map(|clip| clip.frame_count).sum(),
        ..StoredAnimation::default()
    };
    let smallest_first = JointStorage::ALL.into_iter().rev();
    // Where nothing may be off, nothing smaller needs to be tried.
    let only = asked.storage.or((allowed_m <= 0.0).then_some(JointStorage::F32));
    let candidates: Vec<_> = smallest_first.filter(|&storage| only.is_none_or(|one| one == storage)).collect();
    for storage in candidates {
        stored.storage = storage;
        let worst = worst_clip(&points, clips, storage);
        if asked.storage.is_some() || worst.0 <= allowed_m {
            break;
        }
        stored.passed_over.push((storage, worst.0, worst.1));
    }
    let (skeleton, joints) = (views::skeleton_of(raw), views::joints_of(raw));
    let fewest = |(index, clip): (usize, &SampledClip)| match raw.clips.get(index) {
        Some(source) => fewest_frames(&points, &skeleton, &joints, &views::clip_view(source), clip, &stored),
        None => Ok(store_clip(clip, stored.storage, points.joint_count)),
    };
    let kept: Vec<_> = clips.par_iter().enumerate().map(fewest).collect::<Result<_, Cause>>()?;
    let error = |(clip, (kept, _)): (&SampledClip, &(SampledClip, _))| points.apart(clip, kept, f32::INFINITY);
    stored.between = between_frames(raw, &points, (&skeleton, &joints), clips)?;
    stored.error_m = clips.par_iter().zip(&kept).map(error).reduce(|| 0.0, f32::max);
    (stored.clips, stored.texels) = kept.into_iter().unzip();
    Ok(stored)
}

/// The worst place between sampled frames over all clips, as far as looked at: halfway where keys fall on frames and curves are straight between them,
/// at each quarter elsewhere.
fn between_frames(
    raw: &RawCharacter,
    points: &Points,
    rig: (&Skeleton, &[Joint]),
    clips: &[SampledClip],
) -> Result<BetweenFrames, Cause> {
    let vertices = (&points.positions[..], &points.joints[..], &points.weights[..]);
    let of_clip = |(source, clip): (&RawClip, &SampledClip)| {
        let even = key_steps(&key_times(source)).is_some_and(|steps| (clip.frame_count - 1).is_multiple_of(steps));
        let straight = source.tracks.iter().all(|track| track.interpolation == RawInterpolation::Linear);
        let looks = if even && straight { 1 } else { 3 };
        let (distance_m, time_s) = crowd_anim::between_frames(vertices, rig, &views::clip_view(source), clip, looks)?;
        Ok(BetweenFrames { distance_m, clip: clip.name.clone(), time_s })
    };
    let places: Vec<_> = raw.clips.par_iter().zip(clips).map(of_clip).collect::<Result<_, Cause>>()?;
    let farther = |a: BetweenFrames, b: BetweenFrames| if b.distance_m > a.distance_m { b } else { a };
    Ok(places.into_iter().reduce(farther).unwrap_or_default())
}

/// How far a vertex is off, at most, in the worst of the clips with all their frames, and which that is.
fn worst_clip(points: &Points, clips: &[SampledClip], storage: JointStorage) -> (f32, String) {
    let error =
        |clip: &SampledClip| points.apart(clip, &store_clip(clip, storage, points.joint_count).0, f32::INFINITY);
    let errors: Vec<f32> = clips.par_iter().map(error).collect();
    let worst = (1..errors.len()).fold(0, |worst, clip| if errors[clip] > errors[worst] { clip } else { worst });
    (errors.get(worst).copied().unwrap_or(0.0), clips.get(worst).map(|clip| clip.name.clone()).unwrap_or_default())
}

/// The clip as a reader gets it, and its texels.
fn store_clip(clip: &SampledClip, storage: JointStorage, joint_count: usize) -> (SampledClip, Vec<Texel>) {
    let mut texels = Vec::new();
    clip.palettes.chunks_exact(joint_count.max(1)).for_each(|frame| store_frame(storage, frame, &mut texels));
    let palettes = stored_frames(storage, &texels, joint_count as u32);
    (SampledClip { palettes, ..clip.clone() }, texels)
}

/// The clip with as few frames as stay within what is allowed; found by bisection, which takes it that fewer frames are never better.
fn fewest_frames(
    points: &Points,
    skeleton: &Skeleton,
    joints: &[Joint],
    source: &ClipView<'_>,
    clip: &SampledClip,
    stored: &StoredAnimation,
) -> Result<(SampledClip, Vec<Texel>), Cause> {
    let mut best = store_clip(clip, stored.storage, points.joint_count);
    if stored.allowed_m <= 0.0 {
        return Ok(best);
    }
    // Steps from frame to frame: `low` are too few, `high` are enough.
    let (mut low, mut high) = (0, clip.frame_count.saturating_sub(1));
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        let fewer = sample_frames(skeleton, joints, source, middle + 1)?;
        let candidate = store_clip(&fewer, stored.storage, points.joint_count);
        if points.apart(clip, &candidate.0, stored.allowed_m) <= stored.allowed_m {
            (best, high) = (candidate, middle);
        } else {
            low = middle;
        }
    }
    Ok(best)
}

#[cfg(test)]
mod tests;
