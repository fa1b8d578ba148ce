//! Skeleton and clips in, sampled matrix palettes and animated bounds out.
//!
//! Curves are evaluated as glTF 2.0 appendix C says; palettes are what the papers store in animation textures
//! (Peng 2011 §5.3, Dong 2019 §5.1). What it leaves to others: reading files (`crowd-source`), laying the palettes out in
//! a pack (`crowd-pack`).

mod types;

pub use types::*;

/// Samples a clip at about `fps` frames a second.
///
/// Frames: `n = max(1, ceil(duration * fps)) + 1` (1 for a duration of 0), spread evenly so that the last one falls on the
/// clip's end exactly; a closed loop thus ends with the pose it began with. Duration: the largest key time of any track.
///
/// # Errors
/// [`Error::Parameter`] when `fps` is not within 1..=240 or an index points outside.
pub fn sample_clip(skeleton: &Skeleton, joints: &[Joint], clip: &ClipView<'_>, fps: f32) -> Result<SampledClip> {
    let _ = (skeleton, joints, clip, fps);
    unimplemented!("crowd-anim: being written")
}

/// The pose at rest as a clip of one frame, for characters without animations.
pub fn rest_clip(skeleton: &Skeleton, joints: &[Joint]) -> Result<SampledClip> {
    let _ = (skeleton, joints);
    unimplemented!("crowd-anim: being written")
}

/// Bounds over every vertex in every frame given. `palettes` holds whole frames of `joint_count` matrices each.
///
/// The sphere and box hold every skinned vertex even after rounding (a relative 1e-5 is added).
pub fn animated_bounds(
    positions: &[[f32; 3]],
    joints: &[[u16; 4]],
    weights: &[[f32; 4]],
    palettes: &[Mat3x4],
    joint_count: usize,
) -> Bounds {
    let _ = (positions, joints, weights, palettes, joint_count);
    unimplemented!("crowd-anim: being written")
}

/// The smallest bounds that hold all of `bounds` (over clips, say).
pub fn union_bounds(bounds: &[Bounds]) -> Bounds {
    let _ = bounds;
    unimplemented!("crowd-anim: being written")
}
