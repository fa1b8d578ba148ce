//! Points whose distances to the other surface are looked at: which ones, and how far they are.

use super::batches::{Batch, InFrames, LANES, Side};
use super::memory::{Memory, NO_PLACE, Slots};
use super::peaks::Peaks;
use super::{MAXIMUM_SAMPLES, Surface, place};
use crate::closest::{ClosestTriangles, distances_of_lanes};
use crate::measure::{Sample, spread_samples};
use fearless_simd::{Level as Vectors, dispatch};

/// Points whose likely distances are computed in one go.
const AT_ONCE: usize = 16;
/// Every so many points are looked at before the others: they raise the maximum, which spares the others their searches.
const AHEAD: usize = 61;

/// A posed mesh to search.
pub(super) struct Target<'a> {
    pub positions: &'a [[f32; 3]],
    pub triangles: &'a [[u32; 3]],
    pub tree: &'a ClosestTriangles,
}

/// Points on a mesh, each with the triangle of the other mesh that was closest last. To begin with that is the triangle of
/// the same number: what reforming made of it, or what it was made of.
pub(super) struct Points {
    pub samples: Vec<Sample>,
    closest: Vec<u32>,
    /// Where each is remembered, if any are.
    memory: Vec<u32>,
}

impl Points {
    fn new(samples: Vec<Sample>) -> Self {
        Self { closest: samples.iter().map(|sample| sample.triangle).collect(), samples, memory: Vec::new() }
    }

    /// Samples that can lie anywhere but on themselves.
    pub fn samples(samples: &[Sample], unchanged: impl Fn(usize) -> bool) -> Self {
        Self::new(samples.iter().filter(|sample| !unchanged(sample.triangle as usize)).copied().collect())
    }

    /// The vertices of a mesh that `kept` does not use, each as a corner of one of its triangles.
    pub fn vertices(full: &Surface<'_>, kept: Option<&[[u32; 3]]>) -> Self {
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
    pub fn lost(full: &Surface<'_>, kept: Option<&[[u32; 3]]>, unchanged: impl Fn(usize) -> bool) -> Self {
        let mut samples = Self::vertices(full, kept).samples;
        let gone = (0..full.triangles.len()).filter(|&t| !unchanged(t));
        samples.extend(gone.map(|triangle| Sample { triangle: triangle as u32, weights: [1.0 / 3.0; 2] }));
        Self::new(samples)
    }

    /// Middles of triangles and of edges, points by area, and of a mesh of its own the vertices.
    pub fn covering(level: &Surface<'_>, own: bool, unchanged: impl Fn(usize) -> bool) -> Self {
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

    /// Squared distances of all points in one frame: their sum, and the largest.
    pub fn sum_squares<'a>(
        &mut self,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        to: impl FnOnce() -> Target<'a>,
    ) -> (f64, f32) {
        let (mut sum, mut largest) = (0.0_f64, 0.0_f32);
        if self.samples.is_empty() {
            return (sum, largest);
        }
        let to = to();
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

    /// Squared distances of all points in the frames of a batch.
    pub fn squares_in_frames(&mut self, from: &Side<'_>, to: &InFrames<'_>) -> Vec<[f32; LANES]> {
        let (samples, closest, mut waiting) = (&self.samples, &mut self.closest, Vec::new());
        if samples.is_empty() {
            return Vec::new();
        }
        let (tree, rows) = (to.tree, to.rows);
        let mut all = Vec::with_capacity(samples.len());
        dispatch!(Vectors::new(), _ => {
            for (sample, closest) in samples.iter().zip(closest.iter_mut()) {
                let point = from.point(sample);
                let (squares, found) =
                    tree.closest_in_frames(to.boxes, &point, rows.rows, rows.triangles, *closest, &mut waiting);
                *closest = found;
                all.push(squares);
            }
        });
        all
    }

    /// Brings the points into the order of `places`, one a triangle that they lie on: neighbours then come one after the other. `likely`:
    /// for each of these triangles one of the other mesh that was closest at another level, if known.
    pub fn sort_by_place(&mut self, places: &[u32], likely: &[u32]) {
        let place = |sample: &Sample| places[sample.triangle as usize] as usize;
        // Counted, not compared: there are as many points as triangles, at each level.
        let mut next = vec![0_u32; places.len() + 1];
        self.samples.iter().for_each(|sample| next[place(sample) + 1] += 1);
        for at in 1..next.len() {
            next[at] += next[at - 1];
        }
        let mut sorted = self.samples.clone();
        for sample in &self.samples {
            let next = &mut next[place(sample)];
            sorted[*next as usize] = *sample;
            *next += 1;
        }
        self.samples = sorted;
        let likely = |sample: &Sample| likely.get(sample.triangle as usize).copied().unwrap_or(sample.triangle);
        self.closest = self.samples.iter().map(likely).collect();
    }

    /// Has them remembered from level to level. `places`: an order of their triangles in which neighbours are near each other in space.
    pub fn remember(&mut self, slots: &Slots, places: &[u32]) {
        self.memory = self.samples.iter().map(|sample| slots.place(sample, places)).collect();
    }

    /// Notes for each triangle what is closest to one of its points, for another level.
    pub fn note_closest(&self, likely: &mut Vec<u32>) {
        for (sample, &closest) in self.samples.iter().zip(&self.closest) {
            let triangle = sample.triangle as usize;
            for t in likely.len()..=triangle {
                likely.push(t as u32);
            }
            likely[triangle] = closest;
        }
    }

    /// Raises `largest` to the largest distance of the points and between the farthest of them, in the frames of a batch.
    ///
    /// A point no farther from one triangle than half the largest distance so far needs no search; what that triangle is decides
    /// about time alone. Nor does one of which `memory` knows that.
    pub fn raise(
        &mut self,
        largest: &mut Largest,
        batch: &Batch,
        from: &Side<'_>,
        to: &Side<'_>,
        memory: &mut Memory<'_>,
    ) {
        let mut peaks: [Peaks; LANES] = Default::default();
        let vectors = Vectors::new();
        let mut last_found = 0;
        for ahead in [true, false] {
            let (mut at, step) = (0, if ahead { AHEAD } else { 1 });
            while at < self.samples.len() {
                let (mut chunk, mut count) = ([0_usize; AT_ONCE], 0);
                let least = Peaks::least(largest.squared);
                while at < self.samples.len() && count < AT_ONCE {
                    if ahead || at % AHEAD != 0 {
                        let mut counts = true;
                        let place = self.memory.get(at).copied().unwrap_or(NO_PLACE);
                        if let Some(known) = memory.recall(place, self.samples[at].triangle) {
                            self.closest[at] = known.triangle;
                            counts = known.bound > least;
                        }
                        if counts {
                            chunk[count] = at;
                            count += 1;
                        }
                    }
                    at += step;
                }
                let chunk = &chunk[..count];
                let mut near = [[0.0; LANES]; AT_ONCE];
                for &i in chunk {
                    // Where nothing is known, what was closest to the neighbour.
                    if self.closest[i] as usize >= to.triangles.len() {
                        self.closest[i] = last_found;
                    }
                }
                let (samples, closest) = (&self.samples, &self.closest);
                dispatch!(vectors, _ => {
                    for (near, &i) in near.iter_mut().zip(chunk) {
                        *near = distances_of_lanes(&from.point(&samples[i]), &to.corners(closest[i]));
                    }
                });
                for (near, &i) in near.iter_mut().zip(chunk) {
                    let bound = self.search(i, near, largest, batch, from, to, &mut peaks);
                    last_found = self.closest[i];
                    if let Some(&place) = self.memory.get(i) {
                        memory.note(place, last_found, bound);
                    }
                }
            }
        }
        for lane in (0..batch.count).rev() {
            let peaks = std::mem::take(&mut peaks[lane]);
            if peaks.is_empty() {
                continue;
            }
            let found = peaks.climb(largest.squared, from.positions(lane), from.triangles, &to.target(lane));
            // No climb ends below where it was to begin: what is no larger was not found here.
            if found > largest.squared {
                largest.take(found, batch.first + lane);
            }
        }
    }

    /// Searches for one point in the frames in which it may be of interest. `near`: distances to what was closest last. Gives the largest
    /// distance in any frame to what is closest afterwards.
    #[allow(clippy::too_many_arguments, reason = "two sides, a point, and what is found")]
    fn search(
        &mut self,
        i: usize,
        near: &mut [f32; LANES],
        largest: &mut Largest,
        batch: &Batch,
        from: &Side<'_>,
        to: &Side<'_>,
        peaks: &mut [Peaks; LANES],
    ) -> f32 {
        let mut bound = largest_of(near);
        for lane in (0..batch.count).rev() {
            if near[lane] <= Peaks::least(largest.squared) {
                continue;
            }
            let enough = peaks[lane].bar(largest.squared);
            if near[lane] <= enough {
                continue;
            }
            let sample = &self.samples[i];
            let point = place(sample, from.positions(lane), from.triangles);
            let target = to.target(lane);
            let found = target.tree.close_enough(point, target.positions, target.triangles, self.closest[i], enough);
            let Some((found, squared)) = found else { continue };
            largest.take(squared, batch.first + lane);
            peaks[lane].note(sample.triangle, squared, largest.squared);
            if found != self.closest[i] {
                self.closest[i] = found;
                let nearer = distances_of_lanes(&from.point(sample), &to.corners(found));
                bound = largest_of(&nearer);
                near.iter_mut().zip(nearer).for_each(|(near, nearer)| *near = near.min(nearer));
            }
        }
        bound
    }
}

fn largest_of(row: &[f32; LANES]) -> f32 {
    row.iter().copied().fold(0.0, f32::max)
}

/// The largest distance found so far, squared, and its frame.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Largest {
    pub squared: f32,
    pub frame: usize,
}

impl Largest {
    /// Of equal ones that of the last frame, whatever comes first.
    pub fn take(&mut self, squared: f32, frame: usize) {
        if squared > self.squared || (squared == self.squared && frame > self.frame) {
            *self = Self { squared, frame };
        }
    }
}
