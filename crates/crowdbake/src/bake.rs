//! The steps of a bake, in order: load, select clips, sample, quantize, simplify, bound, levels.

use crate::appearance::ShownTextures;
use crate::assemble::{expect_storable, used_materials, vertex_records};
use crate::bake_levels::{BakedLevels, LevelsAsked, bake_levels};
use crate::clip_bounds::{bound_clips, hold_refitted};
use crate::emission::show_emission;
use crate::error::{BakeError, Cause, Step};
use crate::inspect::AnimationInspection;
use crate::level_warnings::{expect_reached, say_levels, warn_of_high_floor, warn_of_repeats};
use crate::ordered_mesh::OrderedMesh;
use crate::plan::{Plan, PlanEntry};
use crate::pose::{Mat3x4, pose_positions};
use crate::sample::{FrameRate, frame_factors, sample_clips, warn_of_vanishing};
use crate::select_clips::select_clips;
use crate::size::{height_of, resize, warn_of_size};
use crate::store_animation::{StoredAnimation, store_animation};
use crate::talk::Talk;
use crate::units::counted;
use crate::views::{self, QuantizedMesh};
use crowd_anim::{Bounds, FootContacts, SampledClip};
use crowd_lod::{Appearance, CollapseOrder, Criteria, FrameReport, LodMesh, LodOptions, LodPoses};
use crowd_pack::{AnimationLayout, PackContents};
use crowd_source::{Limits, RawCharacter, Warning};
use rayon::prelude::*;
use std::path::Path;
use std::time::Instant;

/// Seconds that a step took.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct StepTime {
    /// The step.
    pub step: Step,
    /// Wall-clock seconds.
    pub seconds: f64,
}

/// A character after all steps, before it becomes records.
#[derive(Debug)]
pub struct BakedCharacter {
    /// Name in the pack.
    pub name: String,
    /// File name of the asset, without folder.
    pub source: String,
    /// Criteria of the order.
    pub criteria: Criteria,
    /// Frames a second asked for.
    pub fps: FrameRate,
    /// The character as read; only the clips kept.
    pub raw: RawCharacter,
    /// Its vertices as stored.
    pub mesh: QuantizedMesh,
    /// The clips as they are stored, one per clip of `raw`; a single pose at rest when there is none.
    pub animation: StoredAnimation,
    /// Matrices of the pose at rest.
    pub rest_palette: Vec<Mat3x4>,
    /// The order.
    pub order: CollapseOrder,
    /// Bounds of each clip.
    pub clip_bounds: Vec<Bounds>,
    /// When feet stand and how fast they walk, clip by clip.
    pub feet: Vec<FootContacts>,
    /// Bounds over all clips.
    pub bounds: Bounds,
    /// Height of the pose at rest, metres.
    pub height_m: f32,
    /// Levels with tables.
    pub levels: BakedLevels,
    /// Warnings of the import and the bake.
    pub warnings: Vec<Warning>,
    /// How long each step took.
    pub steps: Vec<StepTime>,
}

/// Told about each step and the share of it that is done, 0..=1.
pub type Watch<'a> = &'a (dyn Fn(Step, f32) + Sync);

/// Bakes one asset with the defaults: what tests and tools need most.
///
/// # Errors
/// The first step that refuses the character.
pub fn bake_file(path: &Path) -> Result<PackContents, BakeError> {
    let baked = bake_character(&PlanEntry::of_file(path), false, &|_, _| {})?;
    crate::assemble::assemble(&[baked], AnimationLayout::default())
}

/// Bakes the characters of a plan, several at a time. Results stand in the plan's order, whatever thread made them.
pub(crate) fn bake_plan(plan: &Plan, strict: bool, talk: &Talk<'_>) -> Vec<Result<BakedCharacter, BakeError>> {
    plan.entries
        .par_iter()
        .map(|entry| {
            let started = Instant::now();
            let watch = ShareWatch::new(talk, &entry.name);
            let result = bake_character(entry, strict, &|step, share| watch.tell(step, share))
                .and_then(|baked| expect_storable(&baked, plan.animation_layout).map(|()| baked));
            watch.finish();
            match &result {
                Ok(baked) => say_baked(talk, baked, started.elapsed().as_secs_f64()),
                Err(error) => talk.error(error),
            }
            result
        })
        .collect()
}

/// Bakes one character.
///
/// # Errors
/// The first step that refuses it.
pub fn bake_character(entry: &PlanEntry, strict: bool, watch: Watch<'_>) -> Result<BakedCharacter, BakeError> {
    let name = entry.name.as_str();
    let mut clock = Clock { steps: Vec::new(), since: Instant::now(), watch };

    let mut raw = crowd_source::load_character(&entry.path, &Limits::default())
        .map_err(|error| BakeError::of(Step::Load, name, error))?;
    let mut warnings = std::mem::take(&mut raw.warnings);
    if strict && !warnings.is_empty() {
        let warnings = warnings.iter().map(warning_sentence).collect();
        return Err(BakeError::of(Step::Load, name, Cause::Warned { warnings }));
    }
    if let Some(asked) = entry.size {
        resize(&mut raw, asked).map_err(|cause| BakeError::of(Step::Load, name, cause))?;
    }
    show_emission(&mut raw);
    warnings.append(&mut raw.warnings);
    clock.lap(Step::Load);

    if let Some(patterns) = &entry.clips {
        raw.clips = select_clips(std::mem::take(&mut raw.clips), patterns)
            .map_err(|cause| BakeError::of(Step::SelectClips, name, cause))?;
    }
    clock.lap(Step::SelectClips);

    let (sampled, rest_palette) =
        sample_clips(&raw, entry.fps).map_err(|cause| BakeError::of(Step::Sample, name, cause))?;
    clock.lap(Step::Sample);

    let vanishing = warn_of_vanishing(&raw, &sampled);
    let mesh = views::quantize(&raw.mesh);
    let used: Vec<u32> = raw.mesh.triangles.iter().flatten().copied().collect();
    let height_m = height_at_rest(&mesh, &used, &rest_palette);
    let animation = store_animation(&raw, &mesh, &sampled, height_m, &entry.storage)
        .map_err(|cause| BakeError::of(Step::Quantize, name, cause))?;
    warnings.extend(animation.warning());
    let clips = &animation.clips;
    let frame_factors = frame_factors(&sampled, clips, &entry.clip_weights, entry.fps)
        .map_err(|cause| BakeError::of(Step::Sample, name, cause))?;
    // Feet are looked at in all frames, not in those that are kept.
    let contacts = |clip: &SampledClip| {
        crowd_anim::foot_contacts(&mesh.positions, &mesh.joints, &mesh.weights, clip, raw.joints.len())
    };
    let feet: Vec<FootContacts> = sampled.par_iter().map(contacts).collect();
    drop(sampled);
    clock.lap(Step::Quantize);

    let lod_options = LodOptions {
        criteria: entry.criteria,
        frames: entry.frames,
        frame_factors,
        attribute_weights: entry.attribute_weights,
        coarsest: entry.coarsest(),
    };
    let triangle_materials = views::triangle_materials(&raw.mesh);
    let shown = ShownTextures::of(&raw, &triangle_materials);
    let order = simplify(&raw, &lod_mesh(&raw, &mesh, &triangle_materials, shown.view()), clips, &lod_options, watch)
        .map_err(|error| BakeError::of(Step::Simplify, name, error))?;
    if order.triangles.is_empty() {
        let triangles = raw.mesh.triangles.len();
        return Err(BakeError::of(Step::Simplify, name, Cause::OnlyDegenerate { triangles }));
    }
    warnings.extend(crate::surface_warnings::warn_of_surface(&order.seams));
    warnings.extend(crate::surface_warnings::warn_of_flat_triangles(&raw.mesh.positions, &raw.mesh.triangles));
    if strict {
        let repairs: Vec<String> =
            warnings.iter().filter(|w| w.code.ends_with("-dropped")).map(warning_sentence).collect();
        if !repairs.is_empty() {
            return Err(BakeError::of(Step::Simplify, name, Cause::Warned { warnings: repairs }));
        }
    }
    clock.lap(Step::Simplify);

    let mut clip_bounds = bound_clips(&mesh, &order, clips, raw.joints.len());
    let height_m = height_at_rest(&mesh, &order.vertex_source, &rest_palette);
    clock.lap(Step::Bound);

    let levels = store_levels(&raw, &mesh, &order, &shown, clips, height_m, &entry.levels);
    hold_refitted(&mut clip_bounds, &levels, clips, raw.joints.len());
    let bounds = crowd_anim::union_bounds(&clip_bounds);
    clock.lap(Step::Levels);

    let mut baked = BakedCharacter {
        name: name.to_owned(),
        source: entry.path.file_name().map(|file| file.to_string_lossy().into_owned()).unwrap_or_default(),
        criteria: entry.criteria,
        fps: entry.fps,
        raw,
        mesh,
        animation,
        rest_palette,
        order,
        clip_bounds,
        feet,
        bounds,
        height_m,
        levels,
        warnings,
        steps: clock.steps,
    };
    if strict {
        expect_reached(&baked).map_err(|cause| BakeError::of(Step::Levels, name, cause))?;
    }
    let repeated = warn_of_repeats(&baked);
    if strict && !repeated.is_empty() {
        let warnings = repeated.iter().map(warning_sentence).collect();
        return Err(BakeError::of(Step::Levels, name, Cause::Warned { warnings }));
    }
    // Who says a size knows it.
    let odd_size = || warn_of_size(baked.height_m, baked.bounds.radius);
    let odd_size = if entry.size.is_some() { None } else { odd_size() };
    let odd = repeated.into_iter().chain(warn_of_high_floor(&baked)).chain(odd_size).chain(vanishing);
    let odd: Vec<Warning> = odd.collect();
    baked.warnings.extend(odd);
    Ok(baked)
}

/// A warning in one sentence, with its count where the message does not say it.
pub fn warning_sentence(warning: &Warning) -> String {
    let Warning { code, place, count, message } = warning;
    if *count < 2 || message.contains(&count.to_string()) {
        return format!("{code}: {place}: {message}");
    }
    format!("{code} x {count}: {place}: {message}")
}

fn simplify(
    raw: &RawCharacter,
    lod_mesh: &LodMesh<'_>,
    clips: &[SampledClip],
    options: &LodOptions,
    watch: Watch<'_>,
) -> Result<CollapseOrder, crowd_lod::Error> {
    let baked = bake_poses(clips);
    let poses =
        LodPoses { palettes: &baked.palettes, joint_count: raw.joints.len(), frame_weights: &baked.frame_weights };
    crowd_lod::simplify(lod_mesh, &poses, options, &|share| watch(Step::Simplify, share))
}

/// The character as the simplifier sees it.
pub(crate) fn lod_mesh<'a>(
    raw: &'a RawCharacter,
    mesh: &'a QuantizedMesh,
    triangle_materials: &'a [u16],
    appearance: Appearance<'a>,
) -> LodMesh<'a> {
    LodMesh {
        positions: &mesh.positions,
        normals: &mesh.normals,
        uvs: &raw.mesh.uvs,
        colors: &raw.mesh.colors,
        joints: &mesh.joints,
        weights: &mesh.weights,
        triangles: &raw.mesh.triangles,
        triangle_materials,
        appearance,
    }
}

/// All frames of all clips, one after another.
pub(crate) struct BakePoses {
    /// Frame by frame.
    pub(crate) palettes: Vec<Mat3x4>,
    /// One a frame, summing to 1.
    pub(crate) frame_weights: Vec<f32>,
}

/// The frames that the simplifier sees.
pub(crate) fn bake_poses(clips: &[SampledClip]) -> BakePoses {
    let frame_counts: Vec<u32> = clips.iter().map(|clip| clip.frame_count).collect();
    BakePoses {
        palettes: clips.iter().flat_map(|clip| clip.palettes.iter().copied()).collect(),
        frame_weights: views::frame_weights(&frame_counts),
    }
}

/// The levels that the pack stores, measured on what it stores.
fn store_levels(
    raw: &RawCharacter,
    mesh: &QuantizedMesh,
    order: &CollapseOrder,
    shown: &ShownTextures,
    clips: &[SampledClip],
    height_m: f32,
    asked: &LevelsAsked,
) -> BakedLevels {
    let materials = used_materials(order);
    let texels = |&material: &u16| {
        let texture = raw.materials[usize::from(material)].texture;
        texture.map_or([0.0; 2], |texture| {
            let image = &raw.images[texture.image as usize];
            [image.width as f32, image.height as f32]
        })
    };
    let ordered = OrderedMesh::new(
        vertex_records(mesh, order, &materials).collect(),
        order.triangles.clone(),
        order.collapse_map.clone(),
        order.levels.clone(),
        &materials.iter().map(texels).collect::<Vec<_>>(),
    );
    let ordered = ordered.with_textures(shown.reordered(&order.triangle_source, &materials));
    let palettes: Vec<Mat3x4> = clips.iter().flat_map(|clip| clip.palettes.iter().copied()).collect();
    let frame_counts: Vec<u32> = clips.iter().map(|clip| clip.frame_count).collect();
    let poses = LodPoses {
        palettes: &palettes,
        joint_count: raw.joints.len(),
        frame_weights: &views::frame_weights(&frame_counts),
    };
    bake_levels(&ordered, &poses, height_m, asked)
}

/// What the check of the chosen frames found, in words; `None` where there was nothing to check.
fn check_sentence(frames: &FrameReport) -> Option<String> {
    let check = frames.check?;
    Some(format!(
        "{} of {} frames stand for all: their mean error lies {:.1} % off that of all frames, the worst frame of all has \
         {:.2} times the error of their worst{}{}",
        frames.used,
        frames.given,
        100.0 * check.deviation,
        check.worst_ratio,
        match frames.rerun_count {
            0 => String::new(),
            count => format!("; frames added {}", counted(count as usize, "time")),
        },
        if check.holds { "" } else { "; more than the 3 % or 1.1 allowed, `--frames all` is exact" },
    ))
}

/// Of the vertices listed.
fn height_at_rest(mesh: &QuantizedMesh, vertices: &[u32], rest_palette: &[Mat3x4]) -> f32 {
    let posed = pose_positions(&mesh.positions, &mesh.joints, &mesh.weights, rest_palette);
    height_of(vertices.iter().map(|&vertex| posed[vertex as usize]))
}

fn say_baked(talk: &Talk<'_>, baked: &BakedCharacter, seconds: f64) {
    let (full, coarsest) = (baked.order.levels.last(), baked.order.levels.first());
    let (full, coarsest) = (full.copied().unwrap_or_default(), coarsest.copied().unwrap_or_default());
    talk.note(format_args!(
        "{}: {} triangles down to {}, {} vertices down to {}, {}, {seconds:.1} s",
        baked.name,
        full.triangle_count,
        coarsest.triangle_count,
        full.vertex_count,
        coarsest.vertex_count,
        counted(baked.raw.clips.len(), "clip"),
    ));
    let animation = AnimationInspection::of_bake(baked);
    talk.note(format_args!("  animation: {}", animation.words()));
    if let Some(sentence) = check_sentence(&baked.order.frames) {
        talk.note(format_args!("  {sentence}"));
    }
    say_levels(talk, baked);
    for warning in &baked.warnings {
        talk.warn(format_args!("{}: {}", baked.name, warning_sentence(warning)));
    }
    for step in &baked.steps {
        talk.detail(format_args!("  {}: {} {:.3} s", baked.name, step.step.name(), step.seconds));
    }
}

/// Measures steps.
struct Clock<'a> {
    steps: Vec<StepTime>,
    since: Instant,
    watch: Watch<'a>,
}

impl Clock<'_> {
    fn lap(&mut self, step: Step) {
        self.steps.push(StepTime { step, seconds: self.since.elapsed().as_secs_f64() });
        self.since = Instant::now();
        (self.watch)(step, 1.0);
    }
}

/// Turns steps into the share of a character on the progress bar: nearly all of the time goes into simplification.
struct ShareWatch<'a, 't> {
    talk: &'a Talk<'t>,
    name: &'a str,
    done: std::sync::Mutex<f32>,
}

impl<'a, 't> ShareWatch<'a, 't> {
    fn new(talk: &'a Talk<'t>, name: &'a str) -> Self {
        Self { talk, name, done: std::sync::Mutex::new(0.0) }
    }

    fn tell(&self, step: Step, share: f32) {
        let (start, length) = match step {
            Step::Load => (0.0, 0.04),
            Step::SelectClips | Step::Sample => (0.04, 0.06),
            Step::Quantize => (0.1, 0.0),
            Step::Simplify => (0.1, 0.65),
            Step::Bound => (0.75, 0.05),
            _ => (0.8, 0.2),
        };
        self.reach(start + length * share.clamp(0.0, 1.0), step.name());
    }

    fn finish(&self) {
        self.reach(1.0, "done");
    }

    fn reach(&self, share: f32, step: &str) {
        let mut done = self.done.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if share > *done {
            self.talk.advance(share - *done, self.name, step);
            *done = share;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_warning_says_its_count_once() {
        let sentence = |count: u64, message: &str| {
            warning_sentence(&Warning { code: "odd", place: "mesh".to_owned(), count, message: message.to_owned() })
        };
        assert_eq!(sentence(32, "triangles were left out"), "odd x 32: mesh: triangles were left out");
        assert_eq!(sentence(32, "32 triangles were left out"), "odd: mesh: 32 triangles were left out");
        assert_eq!(sentence(1, "the extension is ignored"), "odd: mesh: the extension is ignored");
    }
}
