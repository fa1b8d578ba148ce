//! Whether a level is reached, how far off it is and where, and what holds the coarsest one back.

mod causes;
mod to_text;

pub use causes::{Cause, Stuck, Words, stuck_positions};
pub use to_text::to_text;

use crate::inspect::{
    DiscreteInspection, MeasuredInspection, OddCounts, clip_name, inspect_discrete, inspect_measured,
};
use crate::measure_packed::measure_packed;
use crate::pose::{Mat3x4, pose_positions};
use crate::unpack::{Unpacked, triangle_target};
use crowd_pack::{LodRecord, ManifestMeasured};
use serde::Serialize;
use std::collections::BTreeMap;

/// Places named at each target.
const MOST_FURTHEST: usize = 4;

/// Places named where there is room for a sentence alone.
const MOST_HELD: usize = 3;

/// Everything about one character's coarsest level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// Name in the pack.
    pub character: String,
    /// File it was baked from.
    pub source: String,
    /// Rules of the bake.
    pub criteria: String,
    /// Full detail.
    pub full: Counts,
    /// The coarsest level.
    pub coarsest: Counts,
    /// What is odd about its surface: kept or dropped with a count, but a hindrance.
    pub odd: OddCounts,
    /// Positions of the coarsest level that cannot move.
    pub stuck_positions: u32,
    /// Positions of the coarsest level that could still move: the bake ended the detail there.
    pub free_positions: u32,
    /// Of the stuck ones, by the bake's words.
    pub obstacles: ObstacleCounts,
    /// Of these, by cause; most first.
    pub causes: Vec<CauseCount>,
    /// Where they are; most first.
    pub places: Vec<Place>,
    /// Levels asked for.
    pub targets: Vec<Target>,
    /// Discrete levels that the bake stored, whatever was asked for here.
    pub stored: Vec<DiscreteInspection>,
}

/// Sizes of a level.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Vertices.
    pub vertices: u32,
    /// Triangles.
    pub triangles: u32,
}

impl From<LodRecord> for Counts {
    fn from(level: LodRecord) -> Self {
        Self { vertices: level.vertex_count, triangles: level.triangle_count }
    }
}

/// Positions that cannot move, by the bake's words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct ObstacleCounts {
    /// Open border or class fixed.
    pub fixed: u32,
    /// Seam without a partner.
    pub seam: u32,
    /// Would change the topology.
    pub topology: u32,
    /// Would flip a triangle.
    pub flip: u32,
}

/// How many positions one cause holds, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct CauseCount {
    /// The cause.
    pub cause: Cause,
    /// Positions.
    pub count: u32,
    /// The cause in words.
    pub what: &'static str,
    /// What to change in the asset.
    pub remedy: &'static str,
    /// A flag of the bake that changes it.
    pub flag: Option<&'static str>,
}

/// Stuck positions of one material near one joint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Place {
    /// Name of the material.
    pub material: String,
    /// Parts of the source that have this material.
    pub parts: Vec<String>,
    /// The joint that moves these positions most.
    pub joint: String,
    /// Positions.
    pub count: u32,
    /// Of these, by cause; most first.
    pub causes: Vec<(Cause, u32)>,
}

/// A level asked for.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Target {
    /// Share of the triangles, 0 to 1.
    pub ratio: f64,
    /// Triangles that share allows.
    pub triangles: u32,
    /// Whether some level is as small.
    pub reached: bool,
    /// The level that comes nearest.
    pub level: Counts,
    /// That level as measured; none where a pack does not say how to measure.
    pub measured: Option<MeasuredInspection>,
    /// Where full detail lies furthest from the level, at rest and in the measured worst frame; furthest first.
    pub furthest: Vec<Furthest>,
}

/// A joint's part of one material, and how far it lies from a level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Furthest {
    /// The joint that moves it most.
    pub joint: String,
    /// Name of the material.
    pub material: String,
    /// Largest distance of its vertices, metres.
    pub max_m: f32,
    /// That far off at rest, which the clips' frames (and so the level's worst point) need not show.
    pub at_rest: bool,
}

/// Explains one character. `ratios`: shares of the triangles that someone wants, above 0 and up to 1.
pub fn explain(character: &Unpacked<'_>, ratios: &[f64]) -> Explanation {
    let (record, manifest) = (character.record, character.manifest);
    let stuck = stuck_positions(character);
    let blocked = manifest.blocked;
    Explanation {
        character: manifest.name.clone(),
        source: manifest.source.clone(),
        criteria: manifest.criteria.clone(),
        full: Counts { vertices: record.vertex_count, triangles: record.triangle_count },
        coarsest: Counts { vertices: record.min_vertex_count, triangles: record.min_triangle_count },
        odd: OddCounts::of_pack(&manifest.seams),
        stuck_positions: blocked.fixed + blocked.seam + blocked.topology + blocked.flip,
        free_positions: blocked.ended,
        obstacles: ObstacleCounts {
            fixed: blocked.fixed,
            seam: blocked.seam,
            topology: blocked.topology,
            flip: blocked.flip,
        },
        causes: count_causes(&stuck, &manifest.criteria),
        places: find_places(character, &stuck),
        targets: find_targets(character, ratios),
        stored: inspect_discrete(character),
    }
}

fn count_causes(stuck: &[Stuck], criteria: &str) -> Vec<CauseCount> {
    let counts = by_cause(stuck.iter().map(|position| position.cause));
    let with_words = |(cause, count): (Cause, u32)| {
        let Words { what, remedy } = cause.words();
        CauseCount { cause, count, what, remedy, flag: cause.flag(criteria) }
    };
    counts.into_iter().map(with_words).collect()
}

/// Causes with their counts, most first, then in their own order.
fn by_cause(causes: impl Iterator<Item = Cause>) -> Vec<(Cause, u32)> {
    let mut counts: BTreeMap<Cause, u32> = BTreeMap::new();
    causes.for_each(|cause| *counts.entry(cause).or_default() += 1);
    let mut counts: Vec<(Cause, u32)> = counts.into_iter().collect();
    counts.sort_by_key(|&(cause, count)| (std::cmp::Reverse(count), cause));
    counts
}

fn find_places(character: &Unpacked<'_>, stuck: &[Stuck]) -> Vec<Place> {
    let manifest = character.manifest;
    let mut groups: BTreeMap<(u32, u16), Vec<Cause>> = BTreeMap::new();
    for position in stuck {
        let vertex = position.vertex as usize;
        groups.entry(place_key(character, vertex)).or_default().push(position.cause);
    }
    let place = |((material, joint), causes): ((u32, u16), Vec<Cause>)| {
        let parts = manifest.parts.iter().filter(|part| part.material == material);
        Place {
            material: manifest.materials[material as usize].clone(),
            parts: parts.map(|part| part.name.clone()).collect(),
            joint: joint_name(character, joint),
            count: causes.len() as u32,
            causes: by_cause(causes.into_iter()),
        }
    };
    let mut places: Vec<Place> = groups.into_iter().map(place).collect();
    // Stable: places of one count stay in the order of materials and joints.
    places.sort_by_key(|place| std::cmp::Reverse(place.count));
    places
}

/// Where most of the positions are that cannot move, in part of a sentence: `most of them: 12 on Steel at joint hand.L (fold), ...`.
/// `None` where nothing is held.
pub fn held_where(character: &Unpacked<'_>) -> Option<String> {
    let places = find_places(character, &stuck_positions(character));
    let (named, others) = places.split_at(places.len().min(MOST_HELD));
    let one = |place: &Place| {
        let causes: Vec<&str> = place.causes.iter().map(|(cause, _)| cause.name()).collect();
        format!("{} on {} at joint {} ({})", place.count, place.material, place.joint, causes.join(", "))
    };
    let words: Vec<String> = named.iter().map(one).collect();
    let begin = if others.is_empty() { "they are" } else { "most of them" };
    (!words.is_empty()).then(|| format!("{begin}: {}", words.join(", ")))
}

fn joint_name(character: &Unpacked<'_>, joint: u16) -> String {
    let node = character.manifest.joints.get(usize::from(joint)).map(|joint| joint.node as usize);
    node.and_then(|node| character.manifest.nodes.get(node)).map(|node| node.name.clone()).unwrap_or_default()
}

/// Material and leading joint of a vertex.
fn place_key(character: &Unpacked<'_>, vertex: usize) -> (u32, u16) {
    (character.vertices[vertex].material(), leading_joint(character, vertex))
}

/// The joint with the largest weight, the first of equals.
fn leading_joint(character: &Unpacked<'_>, vertex: usize) -> u16 {
    let (joints, weights) = (character.joints[vertex], character.weights[vertex]);
    let heaviest = (1..4).fold(0, |best, slot| if weights[slot] > weights[best] { slot } else { best });
    joints[heaviest]
}

fn find_targets(character: &Unpacked<'_>, ratios: &[f64]) -> Vec<Target> {
    let levels: Vec<(LodRecord, bool)> = ratios.iter().map(|&ratio| character.level_of_ratio(ratio)).collect();
    let asked: Vec<LodRecord> = levels.iter().map(|(level, _)| *level).collect();
    let measured = measure_packed(character, &asked);
    let target =
        |((&ratio, (level, reached)), measured): ((&f64, (LodRecord, bool)), Option<ManifestMeasured>)| Target {
            ratio,
            triangles: triangle_target(character.record.triangle_count, ratio),
            reached,
            level: level.into(),
            measured: measured.as_ref().map(|level| inspect_measured(level, clip_name(character.manifest, level))),
            furthest: find_furthest(character, level, measured.as_ref()),
        };
    ratios.iter().zip(levels).zip(measured).map(target).collect()
}

/// Places by their largest distance at rest and in the worst frame, furthest first; those that are not off are left out.
fn find_furthest(character: &Unpacked<'_>, level: LodRecord, measured: Option<&ManifestMeasured>) -> Vec<Furthest> {
    let triangles = character.level_triangles(level);
    let worst = measured.and_then(|m| frame_palette(character, m.max_clip as usize, m.max_frame));
    let mut largest: BTreeMap<(u32, u16), (f32, bool)> = BTreeMap::new();
    let poses = worst.map(|palette| (palette, false)).into_iter().chain([(character.rest_palette(), true)]);
    for (palette, at_rest) in poses {
        let posed = pose_positions(&character.positions, &character.joints, &character.weights, &palette);
        for (vertex, distance_m) in crowd_lod::distances_to_surface(&posed, &posed, &triangles).into_iter().enumerate()
        {
            let place = largest.entry(place_key(character, vertex)).or_default();
            if distance_m > place.0 {
                *place = (distance_m, at_rest);
            }
        }
    }
    let mut furthest: Vec<Furthest> = largest
        .into_iter()
        .filter(|&(_, (max_m, _))| max_m > 0.0 && max_m.is_finite())
        .map(|((material, joint), (max_m, at_rest))| Furthest {
            joint: joint_name(character, joint),
            material: character.manifest.materials[material as usize].clone(),
            max_m,
            at_rest,
        })
        .collect();
    // Stable: equal distances stay in the order of materials and joints.
    furthest.sort_by(|a, b| b.max_m.total_cmp(&a.max_m));
    furthest.truncate(MOST_FURTHEST);
    furthest
}

/// Matrices of one frame of a clip; none where there is no such frame.
pub(crate) fn frame_palette(character: &Unpacked<'_>, clip: usize, frame: u32) -> Option<Vec<Mat3x4>> {
    let frames =
        character.clips.get(clip).filter(|record| frame < record.frame_count).map(|_| character.palettes(clip))?;
    Some(frames.get(frame as usize * character.joint_count()..)?.get(..character.joint_count())?.to_vec())
}

/// The measured level of as many triangles, or the next coarser one, or the coarsest.
pub(crate) fn measured_near<'a>(character: &Unpacked<'a>, level: LodRecord) -> Option<&'a ManifestMeasured> {
    let measured = &character.manifest.measured;
    let coarser = measured.iter().filter(|m| m.triangle_count <= level.triangle_count);
    coarser.max_by_key(|m| m.triangle_count).or_else(|| measured.iter().min_by_key(|m| m.triangle_count))
}
