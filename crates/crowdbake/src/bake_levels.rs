//! The levels that a pack stores beside the continuous order: quantised ones in geometric steps, discrete ones that someone asked
//! for, each with an index table in cache order and measured.

use crate::lod_target::{Distance, LodTarget};
use crate::measure_levels::{
    LevelError, LevelMeasure, LevelShape, MeasuredFrames, SAMPLES_PER_FRAME, measure_worse_frames, poked_shares,
};
use crate::ordered_mesh::OrderedMesh;
use crate::refit_levels::Refitting;
use crate::search_levels::search_levels;
use crate::unpack::triangle_target;
use crowd_lod::{Level, LodPoses, SurfaceError, geometric_levels};
use crowd_pack::{ManifestTarget, VertexRecord, limits};
use rayon::prelude::*;

/// Triangles around a vertex beyond which it is a hub, as for the order; no real character has one.
const HUB_TRIANGLES: u32 = 1024;
/// Vertices in the cache that levels with a hub are ordered for.
const FIFO_VERTICES: u32 = 16;

/// A level with its table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BakedLevel {
    /// Vertices that the indices go up to: a prefix, or its own.
    pub vertex_count: u32,
    /// Three indices a triangle, in an order that suits a vertex cache.
    pub indices: Vec<u32>,
    /// Vertices of its own, where it was refitted.
    pub own: Option<Vec<VertexRecord>>,
    /// As measured.
    pub error: LevelError,
}

/// A level that someone asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct DiscreteLevel {
    /// `lod1` the finest.
    pub name: String,
    /// What was asked for.
    pub target: LodTarget,
    /// False where even the coarsest level has more triangles.
    pub reached: bool,
    /// What came out.
    pub level: BakedLevel,
}

/// A level that someone asked for and that is not stored, since it is another one.
#[derive(Debug, Clone, PartialEq)]
pub struct RepeatedLevel {
    /// What was asked for.
    pub target: LodTarget,
    /// False where even the coarsest level has more triangles.
    pub reached: bool,
    /// The discrete level that it is, by its place; `None` for full detail.
    pub same_as: Option<usize>,
}

/// All levels of a character.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BakedLevels {
    /// Coarsest first, full detail last.
    pub quantized: Vec<BakedLevel>,
    /// Finest first.
    pub discrete: Vec<DiscreteLevel>,
    /// Those asked for that came out as one of these or as full detail.
    pub repeated: Vec<RepeatedLevel>,
    /// Frames measured.
    pub frames: MeasuredFrames,
}

/// What was asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LevelsAsked {
    /// Discrete levels.
    pub targets: Vec<LodTarget>,
    /// Move the vertices of discrete levels to where they lie closest to full detail.
    pub refit: bool,
}

/// A level chosen for a target.
#[derive(Debug, Clone, Copy)]
struct Chosen {
    target: LodTarget,
    reached: bool,
    level: Level,
}

/// Chooses, measures and orders the levels. `poses`: all frames of all clips. `height_m`: the character's.
///
/// The bound of a quantised level is at least that of each finer one, so that the levels within a bound are those from one
/// on.
pub fn bake_levels(mesh: &OrderedMesh, poses: &LodPoses<'_>, height_m: f32, asked: &LevelsAsked) -> BakedLevels {
    let order = &mesh.order;
    let places = geometric_levels(&order.levels, limits::QUANTIZED_LEVELS as usize);
    let quantized: Vec<Level> = places.iter().map(|&index| order.levels[index]).collect();
    let frames = MeasuredFrames::choose(mesh, &quantized[..quantized.len().saturating_sub(1)], poses);
    let palettes = frames.palettes(poses);
    let measuring = LevelMeasure::new(mesh, &frames, &palettes, poses.joint_count, SAMPLES_PER_FRAME);
    let measure = |shapes: &[LevelShape]| measuring.measure(shapes);
    let poke = |shapes: &[LevelShape]| poked_shares(mesh, shapes, &frames, &palettes, poses.joint_count);
    let shapes_of = |levels: &[Level]| -> Vec<LevelShape> {
        levels.iter().map(|level| LevelShape::Shared(mesh.level_triangles(level))).collect()
    };

    let ratios: Vec<Chosen> = asked.targets.iter().filter_map(|&target| choose_by_ratio(mesh, target)).collect();
    let mut levels = quantized.clone();
    levels.extend(ratios.iter().map(|chosen| chosen.level));
    let mut errors = measure(&shapes_of(&levels));
    let mut ratio_errors = errors.split_off(quantized.len());
    for finer in (1..errors.len()).rev() {
        let bound = errors[finer].bound_m;
        let coarser = &mut errors[finer - 1];
        coarser.bound_m = coarser.bound_m.max(bound);
    }
    // Nor below that of the quantised level next above: what was found there may be there still.
    for (chosen, error) in ratios.iter().zip(&mut ratio_errors) {
        let finer = quantized.partition_point(|level| level.triangle_count < chosen.level.triangle_count);
        let bound = errors.get(finer).map_or(0.0, |error| error.bound_m);
        error.bound_m = error.bound_m.max(bound);
    }

    let mut discrete: Vec<(Chosen, SurfaceError)> = ratios.into_iter().zip(ratio_errors).collect();
    let limited: Vec<_> = asked.targets.iter().filter_map(|&t| Some((t, t.limit_m(height_m)?))).collect();
    let limits: Vec<_> = limited.iter().map(|&(_, limit)| limit).collect();
    let found = search_levels(&order.levels, &places, &errors, &limits, |levels| measure(&shapes_of(levels)));
    for ((target, _), found) in limited.into_iter().zip(found) {
        discrete.push((Chosen { target, reached: true, level: order.levels[found.index] }, found.error));
    }
    discrete.sort_by_key(|(chosen, _)| std::cmp::Reverse(chosen.level.triangle_count));
    let before: Vec<(Level, SurfaceError)> = quantized.iter().copied().zip(errors.iter().copied()).collect();
    let measure_refitted = |shapes: &[LevelShape]| {
        let mut errors = measure(shapes);
        measure_worse_frames(mesh, &frames, poses, shapes, &mut errors);
        errors
    };
    let refitting = Refitting { mesh, poses, measure: &measure_refitted, poke: &poke };
    let mut discrete = match asked.refit {
        true => refit_all(&refitting, &before, discrete, height_m),
        false => discrete.into_iter().map(|(chosen, error)| Stored { chosen, error, refitted: None }).collect(),
    };
    discrete.sort_by_key(|stored| std::cmp::Reverse(stored.chosen.level.triangle_count));
    let (discrete, repeated) = without_repeats(discrete, order.triangles.len() as u32);

    levels.truncate(quantized.len());
    levels.extend(discrete.iter().map(|stored| stored.chosen.level));
    errors.extend(discrete.iter().map(|stored| stored.error));
    let mut errors = join(errors, poke(&shapes_of(&levels)));
    let discrete_errors = errors.split_off(quantized.len());
    let quantized = quantized.par_iter().zip(errors).map(|(level, error)| shared_level(mesh, level, error)).collect();
    let discrete =
        discrete.into_iter().zip(discrete_errors).enumerate().map(|(number, (stored, error))| DiscreteLevel {
            name: level_name(number),
            target: stored.chosen.target,
            reached: stored.chosen.reached,
            level: stored.refitted.unwrap_or_else(|| shared_level(mesh, &stored.chosen.level, error)),
        });
    BakedLevels { quantized, discrete: discrete.collect(), repeated, frames }
}

/// A level to store: its error without a refit, and the refitted one where that is better.
struct Stored {
    chosen: Chosen,
    error: SurfaceError,
    refitted: Option<BakedLevel>,
}

/// Refits levels, each once, and tries coarser ones for those asked for by a distance. A refitted level that measures worse than it did
/// before, or that does not keep its limit any more, is left out.
fn refit_all(
    refitting: &Refitting<'_>,
    quantized: &[(Level, SurfaceError)],
    discrete: Vec<(Chosen, SurfaceError)>,
    height_m: f32,
) -> Vec<Stored> {
    let full = quantized.last().map_or(0, |(level, _)| level.triangle_count);
    let by_share = |chosen: &Chosen| matches!(chosen.target.0, ManifestTarget::Ratio(_));
    let mut once: Vec<(Level, SurfaceError)> = discrete
        .iter()
        .filter(|(chosen, _)| by_share(chosen) || chosen.level.triangle_count < full)
        .map(|&(chosen, error)| (chosen.level, error))
        .collect();
    once.dedup_by_key(|(level, _)| level.triangle_count);
    let refitted = refitting.refit(&once);
    let of = |level: &Level| once.iter().position(|(known, _)| known.triangle_count == level.triangle_count);
    let limited: Vec<(usize, (Distance, f32), usize)> = discrete
        .iter()
        .enumerate()
        .filter_map(|(place, (chosen, _))| Some((place, chosen.target.limit_m(height_m)?, of(&chosen.level)?)))
        .collect();
    let limits: Vec<(Distance, f32)> = limited.iter().map(|limited| limited.1).collect();
    let begin: Vec<_> = limited.iter().map(|&(.., at)| (once[at], &refitted[at])).collect();
    let coarser = refitting.coarser(quantized, &limits, &begin);
    let mut stored: Vec<Stored> = discrete
        .into_iter()
        .map(|(chosen, error)| {
            let limit = chosen.target.limit_m(height_m);
            let better = |level: &&BakedLevel| {
                let surface = &level.error.surface;
                surface.rms_m <= error.rms_m && limit.is_none_or(|(distance, most)| distance.of(surface) <= most)
            };
            let refitted = of(&chosen.level).map(|at| &refitted[at]).filter(better).cloned();
            Stored { chosen, error, refitted }
        })
        .collect();
    for ((place, ..), coarser) in limited.into_iter().zip(coarser) {
        let Some(((level, error), level_refitted)) = coarser else { continue };
        let stored = &mut stored[place];
        stored.chosen.level = level;
        (stored.error, stored.refitted) = (error, Some(level_refitted));
    }
    stored
}

/// `lod1` the finest.
pub(crate) fn level_name(number: usize) -> String {
    format!("lod{}", number + 1)
}

/// Each level once, for whom it was asked first; and those asked for that are one of these, or full detail for want of a coarser one
/// within a distance. `discrete`: finest first.
fn without_repeats(discrete: Vec<Stored>, full_triangle_count: u32) -> (Vec<Stored>, Vec<RepeatedLevel>) {
    let (mut kept, mut repeated): (Vec<Stored>, _) = (Vec::new(), Vec::new());
    for stored in discrete {
        let Chosen { target, reached, level } = stored.chosen;
        let by_share = matches!(target.0, ManifestTarget::Ratio(_));
        // Of one level a limit may allow the refitted vertices and another only the original ones.
        let same = |last: &Stored| {
            last.chosen.level.triangle_count == level.triangle_count
                && last.refitted.is_some() == stored.refitted.is_some()
        };
        if kept.last().is_some_and(same) {
            repeated.push(RepeatedLevel { target, reached, same_as: Some(kept.len() - 1) });
        } else if level.triangle_count == full_triangle_count && !by_share {
            repeated.push(RepeatedLevel { target, reached, same_as: None });
        } else {
            kept.push(stored);
        }
    }
    (kept, repeated)
}

/// The largest level of at most that share of the triangles; `None` for other targets.
fn choose_by_ratio(mesh: &OrderedMesh, target: LodTarget) -> Option<Chosen> {
    let ManifestTarget::Ratio(share) = target.0 else { return None };
    let levels = &mesh.order.levels;
    let most = triangle_target(mesh.order.triangles.len() as u32, f64::from(share));
    let fitting = levels.partition_point(|level| level.triangle_count <= most);
    Some(Chosen { target, reached: fitting > 0, level: levels[fitting.saturating_sub(1)] })
}

fn shared_level(mesh: &OrderedMesh, level: &Level, error: LevelError) -> BakedLevel {
    let indices = cache_order(&mesh.level_triangles(level), level.vertex_count);
    BakedLevel { vertex_count: level.vertex_count, indices, own: None, error }
}

fn join(surfaces: Vec<SurfaceError>, poked: Vec<f32>) -> Vec<LevelError> {
    surfaces.into_iter().zip(poked).map(|(surface, poked_share)| LevelError { surface, poked_share }).collect()
}

/// The triangles in an order that lets a GPU shade most vertices once.
pub fn cache_order(triangles: &[[u32; 3]], vertex_count: u32) -> Vec<u32> {
    if triangles.is_empty() {
        return Vec::new();
    }
    let indices = triangles.as_flattened();
    let mut around = vec![0_u32; vertex_count as usize];
    indices.iter().for_each(|&v| around[v as usize] += 1);
    if around.iter().any(|&count| count > HUB_TRIANGLES) {
        // Each triangle of a hub would have all its others valued again: the square of their number.
        return meshopt::optimize_vertex_cache_fifo(indices, vertex_count as usize, FIFO_VERTICES);
    }
    meshopt::optimize_vertex_cache(indices, vertex_count as usize)
}
