//! Measures levels against full detail over frames: mean, maximum with its frame, a bound, texture drift, normals.
//!
//! Full detail is posed once a frame for all levels. The maximum is searched with a bound from below: a point whose last
//! closest triangle is nearer than the maximum so far needs no search; so points are looked at in eight frames at once (`batches`),
//! neighbours after each other, so that a triangle found for one serves many (`points`). Around the farthest points it looks between
//! them (`peaks`). What it takes is two slices of vertices, so that
//! whoever has a pack can measure it again.

mod batches;
mod memory;
mod peaks;
mod points;

use crate::closest::{ClosestTriangles, FrameBoxes, corners_of};
use crate::measure::{Sample, place_of, spread_samples};
use crate::quadrics::{cross, dot, pose_position, sub};
use crate::{LodPoses, Mat3x4};
use batches::{Batch, FRAMES_AT_ONCE, InFrames, LANES, NearOrder, Row, Rows, Side, boxes_in_frames, rows};
use memory::{CORNERS, EDGES, Remembered};
use points::{Largest, Points};
use rayon::prelude::*;

/// Further points on the level that the maximum looks at, spread by area, beside every triangle's middle.
const MAXIMUM_SAMPLES: u32 = 2000;
/// What the bound adds to the maximum found, as a share: points between those looked at, and frames not measured. Found by
/// measuring with more points on other frames, see the tests.
const BOUND_SHARE: f32 = 0.25;
/// And for rounding, as a share of full detail's diagonal at rest.
const BOUND_ROUNDING: f32 = 1.0e-6;

/// Levels measured one after the other, so that each knows what was closest at the one before: at most, and into how many such turns
/// they are shared out for the cores to have work.
const IN_TURN: usize = 16;
const TURNS: usize = 4;

/// A mesh that moves with joints; one entry per vertex.
#[derive(Debug, Clone, Copy, Default)]
pub struct Surface<'a> {
    /// Bind-space positions, metres.
    pub positions: &'a [[f32; 3]],
    /// Unit normals.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates.
    pub uvs: &'a [[f32; 2]],
    /// Joint indices, below the poses' `joint_count`.
    pub joints: &'a [[u16; 4]],
    /// Weights, summing to 1.
    pub weights: &'a [[f32; 4]],
    /// Vertex indices.
    pub triangles: &'a [[u32; 3]],
}

/// A level to measure.
#[derive(Debug, Clone, Copy)]
pub enum LevelSurface<'a> {
    /// Triangles over the vertices of full detail, in the order of the triangles they were made from (those that did not
    /// change are then known to lie on themselves).
    Shared(&'a [[u32; 3]]),
    /// A mesh of its own.
    Own(Surface<'a>),
}

/// What was measured of a level. Distances are between closest points, both ways.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SurfaceError {
    /// Root mean square over area-weighted points and the first `mean_frames` frames, metres.
    pub rms_m: f32,
    /// Largest, over all frames given, metres.
    pub max_m: f32,
    /// Frame of the largest, an index into the poses given.
    pub max_frame: u32,
    /// What no distance exceeds, also between the points and in the frames that were not looked at, metres.
    ///
    /// Rests on measurement, not on proof: the largest distance found and a quarter more.
    pub bound_m: f32,
    /// Texture drift at rest that 95 % of the surface stays below, texels; 0 without textures.
    pub uv_drift_p95_texels: f32,
    /// Mean angle between normals at rest, degrees.
    pub normal_mean_deg: f32,
}

/// Measures levels against full detail.
///
/// `texels`: for each vertex of `full` the texels of its texture along u and v; 0 where it has none. `poses`: the frames
/// to measure. The mean is taken over the first `mean_frames` of them with `samples` points a side, the maximum over all,
/// with all vertices that a level lacks, the middles of the triangles of both and those of the level's edges. A level without triangles measures 0.
///
/// Panics if an index lies outside its slice. Cost: about a search a point and level, and 50 ns more a frame.
pub fn measure_surfaces(
    full: &Surface<'_>,
    texels: &[[f32; 2]],
    levels: &[LevelSurface<'_>],
    poses: &LodPoses<'_>,
    mean_frames: usize,
    samples: u32,
) -> Vec<SurfaceError> {
    SurfaceMeasure::new(full, texels, poses, mean_frames, samples).measure(levels)
}

/// Full detail in one frame.
struct Posed {
    positions: Vec<[f32; 3]>,
    tree: ClosestTriangles,
}

/// Full detail, made ready once for all levels, also for those that are only known once others were measured.
pub struct SurfaceMeasure<'a> {
    full: Surface<'a>,
    texels: &'a [[f32; 2]],
    palettes: &'a [Mat3x4],
    joint_count: usize,
    mean_frames: usize,
    sample_count: u32,
    samples: Vec<Sample>,
    /// Place of each triangle of full detail in a tree at rest.
    places: Vec<u32>,
    /// That tree, and its boxes in the batches of frames that the mean is taken over.
    rest_tree: ClosestTriangles,
    boxes: Vec<Option<FrameBoxes<LANES>>>,
    posed: Vec<Posed>,
    /// Full detail by batches of frames, in an order of its vertices, and its triangles in that order.
    near_order: NearOrder,
    rows: Vec<Vec<Row>>,
    row_triangles: Vec<[u32; 3]>,
    rounding_m: f32,
}

impl<'a> SurfaceMeasure<'a> {
    /// Poses full detail in all frames; what is given is described at [`measure_surfaces`].
    ///
    /// Panics if an index lies outside its slice.
    pub fn new(
        full: &Surface<'a>,
        texels: &'a [[f32; 2]],
        poses: &LodPoses<'a>,
        mean_frames: usize,
        sample_count: u32,
    ) -> Self {
        let frame_count = poses.palettes.len() / poses.joint_count.max(1);
        let mut rest_tree = ClosestTriangles::new(full.positions, full.triangles);
        rest_tree.refit(full.positions, full.triangles);
        let pose_frame = |frame: usize| {
            let positions = pose_surface(full, &poses.palettes[frame * poses.joint_count..][..poses.joint_count]);
            let mut tree = rest_tree.clone();
            tree.refit(&positions, full.triangles);
            Posed { positions, tree }
        };
        let posed: Vec<Posed> = (0..frame_count).into_par_iter().map(pose_frame).collect();
        let places = rest_tree.places();
        let near_order = NearOrder::new(full.positions.len(), full.triangles, &places);
        let rows_of = |batch: &Batch| {
            let frames: Vec<&[[f32; 3]]> = posed[batch.frames()].iter().map(|f| f.positions.as_slice()).collect();
            rows(&frames, near_order.vertices.iter().map(|&v| v as usize))
        };
        let batches = Batch::all(frame_count);
        let rows: Vec<Vec<Row>> = batches.par_iter().map(rows_of).collect();
        let row_triangles = near_order.map(full.triangles);
        let boxes_of = |(batch, rows): (&Batch, &Vec<Row>)| {
            let counts = rest_tree.suits_frames() && frames_of_mean(batch, mean_frames) >= FRAMES_AT_ONCE;
            counts.then(|| boxes_in_frames(&rest_tree, Rows { rows, triangles: &row_triangles }))
        };
        let boxes = batches.par_iter().zip(&rows).map(boxes_of).collect();
        Self {
            full: *full,
            texels,
            palettes: poses.palettes,
            joint_count: poses.joint_count,
            mean_frames,
            sample_count,
            samples: spread_samples(full.positions, full.triangles, sample_count),
            places,
            posed,
            rest_tree,
            boxes,
            rows,
            row_triangles,
            near_order,
            rounding_m: BOUND_ROUNDING * diagonal(full.positions),
        }
    }

    /// Measures levels against full detail. Panics if an index lies outside its slice.
    ///
    /// What was closest at one level is looked at first at the next one: fast where neighbours in the list are alike. It changes no
    /// figure: what is passed over could not, by what is known of it, be the largest distance or a frame's.
    pub fn measure(&self, levels: &[LevelSurface<'_>]) -> Vec<SurfaceError> {
        let in_turn = |levels: &[LevelSurface<'_>]| {
            let is_shared = |level: &&LevelSurface<'_>| matches!(level, LevelSurface::Shared(_));
            let remembers = levels.iter().filter(is_shared).count() > 1;
            let mut likely =
                Likely { remembered: if remembers { self.full.triangles.len() } else { 0 }, ..Likely::default() };
            // Coarser levels keep the triangles of finer ones: the last ones first.
            let errors = levels.iter().rev().map(|level| measure_level_surface(self, level, &mut likely));
            let mut errors: Vec<SurfaceError> = errors.collect();
            errors.reverse();
            errors
        };
        let count = levels.len().div_ceil(TURNS).clamp(1, IN_TURN);
        levels.par_chunks(count).flat_map_iter(in_turn).collect()
    }

    fn palette(&self, frame: usize) -> &[Mat3x4] {
        &self.palettes[frame * self.joint_count..][..self.joint_count]
    }
}

/// What was closest at the level before, by triangle: of full detail and of the level.
#[derive(Default)]
struct Likely<'l> {
    to_level: Vec<u32>,
    to_full: Vec<u32>,
    /// Triangles of the level before, where it shares its vertices with this one.
    before: &'l [[u32; 3]],
    /// Triangles whose points are remembered; none where no level follows that could ask.
    remembered: usize,
    /// How far the points of full detail and of the level lay from those.
    lost: Remembered,
    covered: Remembered,
}

fn measure_level_surface<'l>(
    reference: &SurfaceMeasure<'_>,
    level: &LevelSurface<'l>,
    likely: &mut Likely<'l>,
) -> SurfaceError {
    let (full, mean_frames, samples) = (&reference.full, reference.mean_frames, reference.sample_count);
    let (surface, own) = match level {
        LevelSurface::Shared(triangles) => (Surface { triangles, ..*full }, false),
        LevelSurface::Own(surface) => (*surface, true),
    };
    if surface.triangles.is_empty() || full.triangles.is_empty() {
        return SurfaceError::default();
    }
    let unchanged = |t: usize| !own && full.triangles.get(t) == surface.triangles.get(t);
    let tree = ClosestTriangles::new(surface.positions, surface.triangles);
    let level_samples = spread_samples(surface.positions, surface.triangles, samples);
    let mut there = Points::samples(&reference.samples, unchanged);
    let mut back = Points::samples(&level_samples, unchanged);
    let mut lost = Points::lost(full, if own { None } else { Some(surface.triangles) }, unchanged);
    lost.sort_by_place(&reference.places, &likely.to_level);
    let mut covered = Points::covering(&surface, own, unchanged);
    covered.sort_by_place(&tree.places(), &likely.to_full);

    let before = std::mem::take(&mut likely.before);
    let same: Vec<bool> = match level {
        LevelSurface::Shared(triangles) => {
            likely.before = triangles;
            triangles.iter().enumerate().map(|(t, corners)| before.get(t) == Some(corners)).collect()
        }
        LevelSurface::Own(_) => Vec::new(),
    };
    if !own {
        lost.remember(&CORNERS, &reference.places);
        covered.remember(&EDGES, &reference.places);
    }
    likely.lost.next_level();
    likely.covered.next_level();
    let row_triangles = if own { Vec::new() } else { reference.near_order.map(surface.triangles) };

    let (mut sum, mut largest) = (0.0_f64, Largest::default());
    // The last frames are the worst: they raise the maximum first, and spare the others their searches.
    for (number, (batch, full_rows)) in Batch::all(reference.posed.len()).iter().zip(&reference.rows).enumerate() {
        let originals = &reference.posed[batch.frames()];
        let original_positions: Vec<&[[f32; 3]]> = originals.iter().map(|posed| posed.positions.as_slice()).collect();
        let moved: Vec<Vec<[f32; 3]>> = match own {
            true => batch.frames().map(|frame| pose_surface(&surface, reference.palette(frame))).collect(),
            false => Vec::new(),
        };
        let moved: Vec<&[[f32; 3]]> = moved.iter().map(Vec::as_slice).collect();
        let moved_rows = rows(&moved, 0..surface.positions.len());
        let full_trees = originals.iter().map(|posed| &posed.tree).collect();
        let all_rows = Rows { rows: full_rows, triangles: &reference.row_triangles };
        let full_side = Side::ready(full.triangles, all_rows, original_positions.clone(), full_trees);
        let (level_rows, level_positions) = match own {
            true => (Rows { rows: &moved_rows, triangles: surface.triangles }, moved),
            false => (Rows { rows: full_rows, triangles: &row_triangles }, original_positions),
        };
        let level_side = Side::of_rest(surface.triangles, level_rows, level_positions, &tree);
        let mean_lanes = (0..frames_of_mean(batch, mean_frames)).rev();
        let known = reference.boxes[number].as_ref().filter(|_| tree.suits_frames());
        let in_frames = known.and_then(|boxes| Some((boxes, level_side.in_frames()?)));
        if let Some((boxes, in_level)) = in_frames {
            let in_full = InFrames { tree: &reference.rest_tree, boxes, rows: all_rows };
            let squares =
                [there.squares_in_frames(&full_side, &in_level), back.squares_in_frames(&level_side, &in_full)];
            for lane in mean_lanes {
                for squares in &squares {
                    let of_lane = || squares.iter().map(|row| row[lane]);
                    sum += of_lane().map(f64::from).sum::<f64>();
                    largest.take(of_lane().fold(0.0, f32::max), batch.first + lane);
                }
            }
        } else {
            for lane in mean_lanes {
                for (points, from, to) in [(&mut there, &full_side, &level_side), (&mut back, &level_side, &full_side)]
                {
                    let (squares, far) = points.sum_squares(from.positions(lane), from.triangles, || to.target(lane));
                    sum += squares;
                    largest.take(far, batch.first + lane);
                }
            }
        }
        let mut memory = likely.lost.of_batch(number, &same, &CORNERS, likely.remembered);
        lost.raise(&mut largest, batch, &full_side, &level_side, &mut memory);
        let mut memory = likely.covered.of_batch(number, &same, &EDGES, likely.remembered);
        covered.raise(&mut largest, batch, &level_side, &full_side, &mut memory);
    }
    lost.note_closest(&mut likely.to_level);
    covered.note_closest(&mut likely.to_full);
    let count = mean_frames.min(reference.posed.len()) as f64 * (reference.samples.len() + level_samples.len()) as f64;
    let attributes = compare_at_rest(reference, &surface, tree, unchanged);
    let max_m = largest.squared.sqrt();
    SurfaceError {
        rms_m: if count > 0.0 { (sum / count).sqrt() as f32 } else { 0.0 },
        max_m,
        max_frame: largest.frame as u32,
        bound_m: if largest.squared > 0.0 { max_m * (1.0 + BOUND_SHARE) + reference.rounding_m } else { 0.0 },
        uv_drift_p95_texels: attributes.0,
        normal_mean_deg: attributes.1,
    }
}

/// Frames of a batch, its first ones, that the mean is taken over.
fn frames_of_mean(batch: &Batch, mean_frames: usize) -> usize {
    mean_frames.saturating_sub(batch.first).min(batch.count)
}

/// At rest, from points of full detail to the closest ones of the level that face the same way: the 95th percentile of the
/// texture drift in texels, and the mean angle between normals in degrees.
fn compare_at_rest(
    reference: &SurfaceMeasure<'_>,
    level: &Surface<'_>,
    mut tree: ClosestTriangles,
    unchanged: impl Fn(usize) -> bool,
) -> (f32, f32) {
    let full = &reference.full;
    tree.refit(level.positions, level.triangles);
    let (mut drifts, mut angle_sum, mut facing) = (Vec::new(), 0.0_f64, 0_u32);
    for sample in &reference.samples {
        let corners = full.triangles[sample.triangle as usize];
        let texels = reference.texels[corners[0] as usize];
        if unchanged(sample.triangle as usize) {
            facing += 1;
            if texels[0] > 0.0 {
                drifts.push(0.0);
            }
            continue;
        }
        let point = place(sample, full.positions, full.triangles);
        let front = face(corners.map(|v| full.positions[v as usize]));
        let hint = Some(sample.triangle).filter(|&t| (t as usize) < level.triangles.len());
        let found = tree.closest_point(point, level.positions, level.triangles, Some(front), hint);
        let Some(hit) = found else { continue };
        let closest = level.triangles[hit.triangle as usize];
        facing += 1;
        let [s, t] = sample.weights;
        let (here, there) = ([s, t, 1.0 - s - t], hit.weights);
        angle_sum += angle(blend(full.normals, corners, here), blend(level.normals, closest, there));
        if texels[0] > 0.0 {
            let (uv, other) = (blend(full.uvs, corners, here), blend(level.uvs, closest, there));
            let drift = [(uv[0] - other[0]) * texels[0], (uv[1] - other[1]) * texels[1]];
            drifts.push((drift[0] * drift[0] + drift[1] * drift[1]).sqrt());
        }
    }
    drifts.sort_unstable_by(f32::total_cmp);
    let p95 = drifts.get(drifts.len().saturating_sub(1) * 95 / 100).copied().unwrap_or(0.0);
    (p95, if facing == 0 { 0.0 } else { (angle_sum / f64::from(facing)).to_degrees() as f32 })
}

pub(crate) fn pose_surface(surface: &Surface<'_>, palette: &[Mat3x4]) -> Vec<[f32; 3]> {
    let pose = |i: usize| pose_position(surface.positions[i], surface.joints[i], surface.weights[i], palette);
    (0..surface.positions.len()).map(pose).collect()
}

fn diagonal(positions: &[[f32; 3]]) -> f32 {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for p in positions {
        (low, high) = ([0, 1, 2].map(|i| low[i].min(p[i])), [0, 1, 2].map(|i| high[i].max(p[i])));
    }
    let extent = sub(high, low).map(|length| length.max(0.0));
    dot(extent, extent).sqrt()
}

/// Where a point of a mesh lies.
fn place(sample: &Sample, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> [f32; 3] {
    place_of(sample, corners_of(triangles[sample.triangle as usize], positions))
}

fn face([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    cross(sub(b, a), sub(c, a))
}

fn blend<const N: usize>(values: &[[f32; N]], corners: [u32; 3], weights: [f32; 3]) -> [f32; N] {
    std::array::from_fn(|i| (0..3).map(|c| weights[c] * values[corners[c] as usize][i]).sum())
}

/// Radians between two directions; 0 where one has no length.
fn angle(a: [f32; 3], b: [f32; 3]) -> f64 {
    let turned = cross(a, b);
    libm::atan2(f64::from(dot(turned, turned)).sqrt(), f64::from(dot(a, b)))
}

#[cfg(test)]
mod tests;
