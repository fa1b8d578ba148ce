//! Clips to frames: samples them, sees that their matrices are of use, and says how much each frame counts.

use crate::error::Cause;
use crate::pose::Mat3x4;
use crate::select_clips::matching_clips;
use crate::units::counted;
use crate::views;
use crowd_anim::{FRAME_TOLERANCE, SampledClip, USUAL_FPS, key_steps};
use crowd_source::{RawCharacter, RawClip, Warning};
use rayon::prelude::*;

/// Matrices over all frames of one character: bounds what sampling may allocate (112 bytes each as sampled, 1.75 GiB; as many again as
/// they are stored).
const MATRICES: u64 = 1 << 24;

/// Largest number in a matrix: what the simplifier computes with.
const RANGE: f32 = 1.0e6;

/// Rates that differ by less, relatively, are one: key times are rounded.
const SAME_RATE: f32 = 0.01;

/// Longest column of a matrix whose joint is taken to have no size.
const NO_SIZE: f32 = 1.0e-6;

/// At which rate clips are sampled.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum FrameRate {
    /// Each clip at the rate of its keys, from 20 to 60 frames a second; at [`USUAL_FPS`] where they lie on no even grid.
    #[default]
    Auto,
    /// So many frames a second, 1 to 240.
    Fixed(f32),
}

impl FrameRate {
    /// What is asked for on the command line.
    ///
    /// # Errors
    /// What was found and what is allowed.
    pub fn parse(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let fps: f32 = text.parse().map_err(|_| "not a number, nor `auto`".to_owned())?;
        Self::fixed(fps).ok_or_else(|| format!("found {fps}, allowed 1 to 240, or `auto`"))
    }

    /// So many frames a second, if that is allowed.
    pub fn fixed(fps: f32) -> Option<Self> {
        (1.0..=240.0).contains(&fps).then_some(Self::Fixed(fps))
    }

    /// The rate as packs have it: 0 for [`FrameRate::Auto`].
    pub fn code(self) -> f32 {
        if let Self::Fixed(fps) = self { fps } else { 0.0 }
    }

    /// The rate of a pack.
    pub fn of_code(code: f32) -> Self {
        if code > 0.0 { Self::Fixed(code) } else { Self::Auto }
    }

    /// Frames of a clip. `tracks`: key times of each of its tracks.
    pub fn frames_of(self, tracks: &[&[f32]]) -> f64 {
        let duration_s = tracks.iter().filter_map(|times| times.last()).fold(0.0_f32, |a, &b| a.max(b));
        let at = |fps: f32| (f64::from(duration_s) * f64::from(fps) - FRAME_TOLERANCE).ceil().max(1.0);
        let steps = match self {
            Self::Fixed(fps) => at(fps),
            Self::Auto => key_steps(tracks).map_or_else(|| at(USUAL_FPS), f64::from),
        };
        if duration_s > 0.0 { steps + 1.0 } else { 1.0 }
    }
}

impl std::fmt::Display for FrameRate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("the rate of their keys"),
            Self::Fixed(fps) => write!(f, "{fps} frames a second"),
        }
    }
}

/// Key times of each of a clip's tracks.
pub(crate) fn key_times(clip: &RawClip) -> Vec<&[f32]> {
    clip.tracks.iter().map(|track| &track.times[..]).collect()
}

/// Samples all clips, or the pose at rest where there is none; and the pose at rest for pictures and the height.
pub(crate) fn sample_clips(raw: &RawCharacter, rate: FrameRate) -> Result<(Vec<SampledClip>, Vec<Mat3x4>), Cause> {
    let frames = raw.clips.iter().map(|clip| rate.frames_of(&key_times(clip)));
    let matrices = frames.sum::<f64>() * raw.joints.len() as f64;
    if matches!(matrices.partial_cmp(&(MATRICES as f64)), None | Some(std::cmp::Ordering::Greater)) {
        return Err(Cause::Limit {
            what: "matrices over all frames",
            found: matrices as u64,
            allowed: MATRICES,
            remedy: "keep fewer clips with --clips or sample with a lower --fps",
        });
    }
    let (skeleton, joints) = (views::skeleton_of(raw), views::joints_of(raw));
    let rest = crowd_anim::rest_clip(&skeleton, &joints)?;
    let rest_palette = rest.palettes.clone();
    if raw.clips.is_empty() {
        return Ok((vec![rest], rest_palette));
    }
    let sampled: Result<Vec<_>, Cause> = raw
        .clips
        .par_iter()
        .map(|clip| {
            let view = views::clip_view(clip);
            let sampled = match (rate, key_steps(&key_times(clip))) {
                (FrameRate::Fixed(fps), _) => crowd_anim::sample_clip(&skeleton, &joints, &view, fps)?,
                (FrameRate::Auto, Some(steps)) => crowd_anim::sample_frames(&skeleton, &joints, &view, steps + 1)?,
                (FrameRate::Auto, None) => crowd_anim::sample_clip(&skeleton, &joints, &view, USUAL_FPS)?,
            };
            expect_in_range(raw, &sampled)?;
            Ok(sampled)
        })
        .collect();
    Ok((sampled?, rest_palette))
}

/// For each frame that is kept of all clips, how much it counts; empty where all count alike. A frame stands for those that were
/// left out beside it, so a clip counts by its time, however few of its frames are kept.
pub(crate) fn frame_factors(
    sampled: &[SampledClip],
    kept: &[SampledClip],
    clip_weights: &[(String, f32)],
    rate: FrameRate,
) -> Result<Vec<f32>, Cause> {
    let mut factors = vec![1.0_f32; kept.len()];
    for (asked, weight) in clip_weights {
        let names = kept.iter().map(|clip| clip.name.as_str());
        for index in matching_clips(names, asked)? {
            factors[index] *= weight;
        }
    }
    // Clips that were sampled at rates of their own count by their time all the same: a frame of a denser one counts less.
    let density = |clip: &SampledClip| f64::from(clip.frame_count.saturating_sub(1)) / f64::from(clip.duration_s);
    let densities: Vec<f64> = sampled.iter().map(density).collect();
    let first = densities.iter().copied().find(|density| density.is_finite() && *density > 0.0).unwrap_or(1.0);
    for (index, (factor, (sampled, kept))) in factors.iter_mut().zip(sampled.iter().zip(kept)).enumerate() {
        let ratio = (densities[index] / first) as f32;
        let is_even = rate != FrameRate::Auto || !ratio.is_finite() || ratio <= 0.0 || (ratio - 1.0).abs() < SAME_RATE;
        *factor *= sampled.frame_count as f32 / kept.frame_count.max(1) as f32;
        *factor /= if is_even { 1.0 } else { ratio };
    }
    if factors.iter().all(|factor| *factor == 0.0) {
        return Err(Cause::NothingWeighs);
    }
    if factors.iter().all(|factor| *factor == 1.0) {
        return Ok(Vec::new());
    }
    let frames = kept.iter().zip(&factors);
    Ok(frames.flat_map(|(clip, &factor)| std::iter::repeat_n(factor, clip.frame_count as usize)).collect())
}

/// Refuses a clip that moves or scales a joint beyond all sizes, by joint and time.
fn expect_in_range(raw: &RawCharacter, clip: &SampledClip) -> Result<(), Cause> {
    let far = |matrix: &Mat3x4| matrix.as_flattened().iter().any(|number| number.abs() > RANGE);
    let Some(at) = clip.palettes.iter().position(far) else { return Ok(()) };
    let (frame, joint) = (at / raw.joints.len(), at % raw.joints.len());
    let seconds = clip.duration_s * frame as f32 / (clip.frame_count - 1).max(1) as f32;
    let largest = clip.palettes[at].as_flattened().iter().fold(0.0_f32, |largest, number| largest.max(number.abs()));
    let joint = raw.nodes[raw.joints[joint].node as usize].name.clone();
    Err(Cause::PoseTooLarge { clip: clip.name.clone(), seconds, joint, found: largest })
}

/// Says so where clips scale joints to nothing: what follows those alone is not seen there. Meant now and then, as for a sword that is put away.
pub(crate) fn warn_of_vanishing(raw: &RawCharacter, clips: &[SampledClip]) -> Vec<Warning> {
    let gone = |matrix: &Mat3x4| {
        (0..3)
            .all(|column| (0..3).map(|row| matrix[row][column] * matrix[row][column]).sum::<f32>() < NO_SIZE * NO_SIZE)
    };
    let vanishing = |clip: &SampledClip| {
        let frames = clip.palettes.chunks_exact(raw.joints.len().max(1));
        let mut joints = vec![false; raw.joints.len()];
        let mut count = 0;
        for palette in frames {
            let mut any = false;
            for (joint, matrix) in palette.iter().enumerate() {
                let gone = gone(matrix);
                joints[joint] |= gone;
                any |= gone;
            }
            count += u64::from(any);
        }
        let names: Vec<&str> = (0..joints.len())
            .filter(|&joint| joints[joint])
            .map(|joint| raw.nodes[raw.joints[joint].node as usize].name.as_str())
            .collect();
        let first = names.first()?;
        Some(Warning {
            code: "joints-vanish",
            place: format!("clip `{}`", clip.name),
            count,
            message: format!(
                "{} without size in {} of {}, the first is `{first}`; what follows only those cannot be seen there",
                counted(names.len(), "joint"),
                count,
                counted(clip.frame_count as usize, "frame"),
            ),
        })
    };
    clips.iter().filter_map(vanishing).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crowd_anim::RootMotion;

    #[test]
    fn a_clip_counts_by_its_time_however_few_frames_are_kept() {
        let clip = |(name, frame_count): (&str, u32)| SampledClip {
            name: name.to_owned(),
            duration_s: 1.0,
            frame_count,
            palettes: Vec::new(),
            worlds: Vec::new(),
            root_motion: RootMotion::default(),
            loop_gap_m: 0.0,
        };
        let rate = FrameRate::Fixed(30.0);
        let of = |counts: [u32; 2]| ["idle", "walk"].into_iter().zip(counts).map(clip).collect::<Vec<_>>();
        assert_eq!(frame_factors(&of([6, 3]), &of([6, 3]), &[], rate).expect("no names"), Vec::<f32>::new());
        assert_eq!(frame_factors(&of([6, 3]), &of([2, 3]), &[], rate).expect("no names"), [3.0, 3.0, 1.0, 1.0, 1.0]);
        // Sampled at twice the rate, the second clip's frames count half.
        let mut denser = of([6, 11]);
        assert_eq!(frame_factors(&denser, &denser, &[], rate).expect("no names"), Vec::<f32>::new());
        let auto = FrameRate::Auto;
        assert_eq!(frame_factors(&denser, &denser, &[], auto).expect("no names")[6..], [0.5; 11]);
        denser[1].duration_s = 2.0;
        assert_eq!(frame_factors(&denser, &denser, &[], auto).expect("no names"), Vec::<f32>::new());
        let twice = [("walk".to_owned(), 2.0)];
        assert_eq!(frame_factors(&of([6, 2]), &of([2, 2]), &twice, rate).expect("one is there"), [3.0, 3.0, 2.0, 2.0]);
        let none = [("*".to_owned(), 0.0)];
        let error = frame_factors(&of([6, 2]), &of([2, 2]), &none, rate).expect_err("nothing counts");
        assert!(error.to_string().contains("--clip-weight"), "{error}");
    }
}
