//! Measures levels against full detail over frames: mean, maximum with its frame, a bound, texture drift, normals.
//!
//! Full detail is posed once a frame for all levels. The maximum is searched with a bound from below: a point whose last
//! closest triangle is nearer than the maximum so far needs no search. Around the farthest points it looks between them
//! (`peaks`). What it takes is two slices of vertices, so that
//! whoever has a pack can measure it again.

mod peaks;

use crate::closest::{ClosestTriangles, corners_of, distances_squared};
use crate::measure::{Sample, place_of, spread_samples};
use crate::quadrics::{cross, dot, pose_position, sub};
use crate::{LodPoses, Mat3x4};
use fearless_simd::{Level as Vectors, dispatch};
use peaks::Peaks;
use rayon::prelude::*;

/// Further points on the level that the maximum looks at, spread by area, beside every triangle's middle.
const MAXIMUM_SAMPLES: u32 = 2000;
/// Points whose likely distances are computed in one go.
const AT_ONCE: usize = 8;
/// What the bound adds to the maximum found, as a share: points between those looked at, and frames not measured. Found by
/// measuring with more points on other frames, see the tests.
const BOUND_SHARE: f32 = 0.25;
/// And for rounding, as a share of full detail's diagonal at rest.
const BOUND_ROUNDING: f32 = 1.0e-6;

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
    posed: Vec<Posed>,
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
        Self {
            full: *full,
            texels,
            palettes: poses.palettes,
            joint_count: poses.joint_count,
            mean_frames,
            sample_count,
            samples: spread_samples(full.positions, full.triangles, sample_count),
            posed: (0..frame_count).into_par_iter().map(pose_frame).collect(),
            rounding_m: BOUND_ROUNDING * diagonal(full.positions),
        }
    }

    /// Measures levels against full detail. Panics if an index lies outside its slice.
    pub fn measure(&self, levels: &[LevelSurface<'_>]) -> Vec<SurfaceError> {
        levels.par_iter().map(|level| measure_level_surface(self, level)).collect()
    }

    fn palette(&self, frame: usize) -> &[Mat3x4] {
        &self.palettes[frame * self.joint_count..][..self.joint_count]
    }
}

fn measure_level_surface(reference: &SurfaceMeasure<'_>, level: &LevelSurface<'_>) -> SurfaceError {
    let (full, mean_frames, samples) = (&reference.full, reference.mean_frames, reference.sample_count);
    let (surface, own) = match level {
        LevelSurface::Shared(triangles) => (Surface { triangles, ..*full }, false),
        LevelSurface::Own(surface) => (*surface, true),
    };
    if surface.triangles.is_empty() || full.triangles.is_empty() {
        return SurfaceError::default();
    }
    let unchanged = |t: usize| !own && full.triangles.get(t) == surface.triangles.get(t);
    let mut tree = ClosestTriangles::new(surface.positions, surface.triangles);
    let level_samples = spread_samples(surface.positions, surface.triangles, samples);
    let mut there = Points::samples(&reference.samples, unchanged);
    let mut back = Points::samples(&level_samples, unchanged);
    let mut lost = Points::lost(full, if own { None } else { Some(surface.triangles) }, unchanged);
    let mut covered = Points::covering(&surface, own, unchanged);

    let (mut sum, mut largest, mut max_frame) = (0.0_f64, 0.0_f32, 0);
    // The last frames are the worst: they raise the maximum first, and spare the others their searches.
    for frame in (0..reference.posed.len()).rev() {
        let original = &reference.posed[frame];
        let moved = own.then(|| pose_surface(&surface, reference.palette(frame)));
        let positions: &[[f32; 3]] = moved.as_deref().unwrap_or(&original.positions);
        tree.refit(positions, surface.triangles);
        let to_level = Target { positions, triangles: surface.triangles, tree: &tree };
        let to_full = Target { positions: &original.positions, triangles: full.triangles, tree: &original.tree };
        let before = largest;
        if frame < mean_frames {
            for (points, from, to) in [
                (&mut there, (&original.positions[..], full.triangles), &to_level),
                (&mut back, (positions, surface.triangles), &to_full),
            ] {
                let (squares, far) = points.sum_squares(from.0, from.1, to);
                sum += squares;
                largest = largest.max(far);
            }
        }
        largest = lost.raise(largest, &original.positions, full.triangles, &to_level);
        largest = covered.raise(largest, positions, surface.triangles, &to_full);
        if largest > before || frame + 1 == reference.posed.len() {
            max_frame = frame as u32;
        }
    }
    let count = mean_frames.min(reference.posed.len()) as f64 * (reference.samples.len() + level_samples.len()) as f64;
    let attributes = compare_at_rest(reference, &surface, tree, unchanged);
    let max_m = largest.sqrt();
    SurfaceError {
        rms_m: if count > 0.0 { (sum / count).sqrt() as f32 } else { 0.0 },
        max_m,
        max_frame,
        bound_m: if largest > 0.0 { max_m * (1.0 + BOUND_SHARE) + reference.rounding_m } else { 0.0 },
        uv_drift_p95_texels: attributes.0,
        normal_mean_deg: attributes.1,
    }
}

/// A posed mesh to search.
struct Target<'a> {
    positions: &'a [[f32; 3]],
    triangles: &'a [[u32; 3]],
    tree: &'a ClosestTriangles,
}

/// Points on a mesh, each with the triangle of the other mesh that was closest last. To begin with that is the triangle of
/// the same number: what reforming made of it, or what it was made of.
struct Points {
    samples: Vec<Sample>,
    closest: Vec<u32>,
}

impl Points {
    fn new(samples: Vec<Sample>) -> Self {
        Self { closest: samples.iter().map(|sample| sample.triangle).collect(), samples }
    }

    /// Samples that can lie anywhere but on themselves.
    fn samples(samples: &[Sample], unchanged: impl Fn(usize) -> bool) -> Self {
        Self::new(samples.iter().filter(|sample| !unchanged(sample.triangle as usize)).copied().collect())
    }

    /// The vertices of a mesh that `kept` does not use, each as a corner of one of its triangles.
    fn vertices(full: &Surface<'_>, kept: Option<&[[u32; 3]]>) -> Self {
        let mut seen = vec![false; full.positions.len()];
        kept.unwrap_or_default().as_flattened().iter().for_each(|&v| seen[v as usize] = true);
        let mut samples = Vec::new();
        for (triangle, corners) in full.triangles.iter().enumerate() {
            for (corner, weights) in corners.iter().zip([[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]) {
                if !std::mem::replace(&mut seen[*corner as usize], true) {
                    samples.push(Sample { triangle: triangle as u32, weights });
                }
            }
        }
        Self::new(samples)
    }

    /// The vertices that a level lacks, and the middles of the triangles that it lacks: where a level opens, the corners may stay.
    fn lost(full: &Surface<'_>, kept: Option<&[[u32; 3]]>, unchanged: impl Fn(usize) -> bool) -> Self {
        let mut samples = Self::vertices(full, kept).samples;
        let gone = (0..full.triangles.len()).filter(|&t| !unchanged(t));
        samples.extend(gone.map(|triangle| Sample { triangle: triangle as u32, weights: [1.0 / 3.0; 2] }));
        Self::new(samples)
    }

    /// Middles of triangles and of edges, points by area, and of a mesh of its own the vertices.
    fn covering(level: &Surface<'_>, own: bool, unchanged: impl Fn(usize) -> bool) -> Self {
        const THIRD: f32 = 1.0 / 3.0;
        let mut samples = Vec::new();
        for triangle in (0..level.triangles.len()).filter(|&t| !unchanged(t)) {
            samples.push(Sample { triangle: triangle as u32, weights: [THIRD, THIRD] });
            let [a, b, c] = level.triangles[triangle];
            // Each edge once, of the triangle that lists it upwards.
            for (_, weights) in [(a < b, [0.5, 0.5]), (b < c, [0.0, 0.5]), (c < a, [0.5, 0.0])].iter().filter(|e| e.0) {
                samples.push(Sample { triangle: triangle as u32, weights: *weights });
            }
        }
        let spread = spread_samples(level.positions, level.triangles, MAXIMUM_SAMPLES);
        samples.extend(spread.into_iter().filter(|sample| !unchanged(sample.triangle as usize)));
        if own {
            samples.extend(Self::vertices(level, None).samples);
        }
        Self::new(samples)
    }

    /// Squared distances of all points: their sum, and the largest.
    fn sum_squares(&mut self, positions: &[[f32; 3]], triangles: &[[u32; 3]], to: &Target<'_>) -> (f64, f32) {
        let (mut sum, mut largest) = (0.0_f64, 0.0_f32);
        for (sample, closest) in self.samples.iter().zip(&mut self.closest) {
            let point = place(sample, positions, triangles);
            if let Some((found, squared)) = to.tree.close_enough(point, to.positions, to.triangles, *closest, 0.0) {
                *closest = found;
                sum += f64::from(squared);
                largest = largest.max(squared);
            }
        }
        (sum, largest)
    }

    /// The largest squared distance of the points and between the farthest of them, or `largest` where none is farther.
    fn raise(&mut self, mut largest: f32, positions: &[[f32; 3]], triangles: &[[u32; 3]], to: &Target<'_>) -> f32 {
        let (mut peaks, vectors) = (Peaks::default(), Vectors::new());
        for (samples, closest) in self.samples.chunks(AT_ONCE).zip(self.closest.chunks_mut(AT_ONCE)) {
            let (mut points, mut likely) = ([[0.0; 3]; AT_ONCE], [[[0.0; 3]; 3]; AT_ONCE]);
            for i in 0..AT_ONCE {
                let i_there = if i < samples.len() { i } else { 0 };
                points[i] = place(&samples[i_there], positions, triangles);
                let triangle = to.triangles.get(closest[i_there] as usize).unwrap_or(&to.triangles[0]);
                likely[i] = corners_of(*triangle, to.positions);
            }
            let near = dispatch!(vectors, _ => distances_squared(&points, &likely));
            for (i, closest) in closest.iter_mut().enumerate() {
                let enough = Peaks::least(largest);
                if near[i] <= enough {
                    continue;
                }
                let found = to.tree.close_enough(points[i], to.positions, to.triangles, *closest, enough);
                if let Some((found, squared)) = found {
                    *closest = found;
                    largest = largest.max(squared);
                    peaks.note(samples[i].triangle, squared, largest);
                }
            }
        }
        peaks.climb(largest, positions, triangles, to)
    }
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

fn pose_surface(surface: &Surface<'_>, palette: &[Mat3x4]) -> Vec<[f32; 3]> {
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
