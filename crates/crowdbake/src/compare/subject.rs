//! A character ready to be simplified and judged: what the simplifier sees, and the poses it does not see.

use crate::error::{BakeError, Step};
use crate::plan::PlanEntry;
use crate::pose::Mat3x4;
use crate::sample::sample_clips;
use crate::size::{SizeAsked, resize};
use crate::views::{self, QuantizedMesh};
use crowd_anim::SampledClip;
use crowd_judge::{Judge, JudgeOptions, JudgedPoses, Paint, SkinnedMesh};
use crowd_raster::Texture;
use crowd_source::{Limits, RawCharacter};
use rayon::prelude::*;
use std::path::PathBuf;

/// Moments in motion, spread over all clips by duration.
const MOMENTS: u32 = 24;
/// Larger textures are halved down to this many pixels a side.
const TEXTURE_SIDE_PX: u32 = 4096;

/// A character in a comparison.
pub(super) struct Subject {
    pub(super) path: PathBuf,
    /// How many times as large as in its file, where that was asked for.
    pub(super) size: Option<SizeAsked>,
    pub(super) raw: RawCharacter,
    /// As our bake stores it.
    pub(super) mesh: QuantizedMesh,
    /// The frames that our bake sees.
    pub(super) clips: Vec<SampledClip>,
    pub(super) rest_palette: Vec<Mat3x4>,
    pub(super) triangle_materials: Vec<u16>,
    pub(super) judge: Judge,
    /// Of the judge's moving poses.
    pub(super) moments: Vec<Moment>,
}

/// A time of a clip.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moment {
    pub(super) clip: String,
    pub(super) time_s: f32,
}

impl Subject {
    /// Reads and samples a character, and prepares its judge.
    pub(super) fn load(entry: &PlanEntry, options: JudgeOptions) -> Result<Self, BakeError> {
        let name = entry.name.as_str();
        let mut raw = crowd_source::load_character(&entry.path, &Limits::default())
            .map_err(|error| BakeError::of(Step::Load, name, error))?;
        crate::emission::show_emission(&mut raw);
        let factor = entry.size.map(|asked| resize(&mut raw, asked)).transpose();
        let factor = factor.map_err(|cause| BakeError::of(Step::Load, name, cause))?;
        let (clips, rest_palette) =
            sample_clips(&raw, entry.fps).map_err(|cause| BakeError::of(Step::Sample, name, cause))?;
        let (moments, moving) =
            held_out_poses(&raw, &clips).map_err(|error| BakeError::of(Step::Sample, name, error))?;
        let triangle_materials = views::triangle_materials(&raw.mesh);
        let paint = paint_of(&raw).map_err(|error| BakeError::of(Step::Draw, name, error))?;
        let poses = JudgedPoses { rest: rest_palette.clone(), moving };
        let original = original_mesh(&raw, &triangle_materials);
        let judge =
            Judge::new(original, paint, &poses, options).map_err(|error| BakeError::of(Step::Judge, name, error))?;
        let mesh = views::quantize(&raw.mesh);
        let (path, size) = (entry.path.clone(), factor.map(SizeAsked::Factor));
        Ok(Self { path, size, raw, mesh, clips, rest_palette, triangle_materials, judge, moments })
    }
}

/// The character as its file has it, not as we store it: what rounding costs counts too.
fn original_mesh(raw: &RawCharacter, triangle_materials: &[u16]) -> SkinnedMesh {
    let mesh = &raw.mesh;
    SkinnedMesh {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        uvs: mesh.uvs.clone(),
        colors: mesh.colors.clone(),
        joints: mesh.joints.clone(),
        weights: mesh.weights.clone(),
        triangles: mesh.triangles.clone(),
        triangle_materials: triangle_materials.to_vec(),
    }
}

/// Poses at times that no bake has seen: half way between two frames of a clip, spread over all clips by duration.
fn held_out_poses(
    raw: &RawCharacter,
    clips: &[SampledClip],
) -> Result<(Vec<Moment>, Vec<Vec<Mat3x4>>), crowd_anim::Error> {
    let total_s: f64 = clips.iter().map(|clip| f64::from(clip.duration_s)).sum();
    if raw.clips.is_empty() || total_s <= 0.0 {
        return Ok((Vec::new(), Vec::new()));
    }
    let (skeleton, joints) = (views::skeleton_of(raw), views::joints_of(raw));
    let moment = |i: u32| {
        let mut place_s = (f64::from(i) + 0.5) / f64::from(MOMENTS) * total_s;
        let mut chosen = clips.len() - 1;
        for (c, clip) in clips.iter().enumerate() {
            let duration_s = f64::from(clip.duration_s);
            if place_s < duration_s {
                chosen = c;
                break;
            }
            place_s -= duration_s;
        }
        (chosen, between_frames(&clips[chosen], place_s))
    };
    let poses: Result<Vec<_>, _> = (0..MOMENTS)
        .into_par_iter()
        .map(|i| {
            let (clip, time_s) = moment(i);
            let pose = crowd_anim::pose_at(&skeleton, &joints, &views::clip_view(&raw.clips[clip]), time_s)?;
            Ok((Moment { clip: raw.clips[clip].name.clone(), time_s }, pose))
        })
        .collect();
    Ok(poses?.into_iter().unzip())
}

/// The same poses of a character that another program wrote, by the names of its clips; at rest where a clip is gone.
pub(super) fn own_poses(raw: &RawCharacter, moments: &[Moment]) -> Result<JudgedPoses, crowd_anim::Error> {
    let (skeleton, joints) = (views::skeleton_of(raw), views::joints_of(raw));
    let rest = crowd_anim::rest_clip(&skeleton, &joints)?.palettes;
    let pose = |moment: &Moment| match raw.clips.iter().find(|clip| clip.name == moment.clip) {
        Some(clip) => crowd_anim::pose_at(&skeleton, &joints, &views::clip_view(clip), moment.time_s),
        None => Ok(rest.clone()),
    };
    let moving = moments.par_iter().map(pose).collect::<Result<Vec<_>, _>>()?;
    Ok(JudgedPoses { rest, moving })
}

/// The time half way between the two frames of a clip that a time lies between.
fn between_frames(clip: &SampledClip, time_s: f64) -> f32 {
    let steps = f64::from(clip.frame_count.saturating_sub(1));
    if steps < 1.0 {
        return 0.0;
    }
    let step_s = f64::from(clip.duration_s) / steps;
    let step = (time_s / step_s).floor().clamp(0.0, steps - 1.0);
    ((step + 0.5) * step_s) as f32
}

/// Materials and decoded textures.
fn paint_of(raw: &RawCharacter) -> Result<Paint, crowd_raster::Error> {
    let textures: Result<Vec<Texture>, _> =
        raw.images.par_iter().map(|image| crowd_raster::decode_texture(&image.bytes, TEXTURE_SIDE_PX)).collect();
    Ok(Paint { materials: raw.materials.iter().map(views::raster_material).collect(), textures: textures? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn clip(duration_s: f32, frame_count: u32) -> SampledClip {
        SampledClip {
            name: "walk".to_owned(),
            duration_s,
            frame_count,
            palettes: Vec::new(),
            worlds: Vec::new(),
            root_motion: crowd_anim::RootMotion::default(),
            loop_gap_m: 0.0,
        }
    }

    #[test]
    fn judged_times_lie_half_way_between_baked_ones() {
        let clip = clip(2.0, 5);
        for (time_s, held_out_s) in [(0.0, 0.25), (0.25, 0.25), (0.5, 0.75), (1.999, 1.75), (2.0, 1.75)] {
            assert_eq!(between_frames(&clip, time_s), held_out_s, "{time_s}");
        }
    }
}
