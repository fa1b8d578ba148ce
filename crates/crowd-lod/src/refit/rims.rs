//! Holds the rims of a level's charts to those of full detail: seams, open borders and where two colours meet.
//!
//! Where two colours meet, a rim that is off by some way shows a strip as wide of the wrong one: that costs by the width, not by its
//! square, as much as the colours differ.

use super::charts::RimEdge;
use super::full_detail::FullDetail;
use super::pairs::{Contact, contact};
use super::pulls::{RIM_SHARE, color_metres};
use super::shape::Shape;
use crate::closest::ClosestTriangles;
use crate::quadrics::{cross, dot, sub};
use crate::split_seams::zero_signless_bits;

/// Points along the rims of full detail at most.
const MOST_POINTS: f64 = 40_000.0;
/// How far rims are drawn to each other, in mean edges of the level: part of a rim may have vanished.
const REACH: f64 = 0.5;
/// Points for each mean edge of the level.
const POINTS_PER_EDGE: f64 = 3.0;
/// Strips narrower than this, in mean edges of the level, count by the square of their width after all.
const NARROW: f64 = 0.05;
/// How many times as much a strip costs between plain colours: no texture there hides it, or could slide to mend it.
const PLAIN_FACTOR: f32 = 8.0;
/// Where the colour beside an edge is looked up: weights of its ends, and of the triangle's third corner.
const BESIDE: [f32; 2] = [0.425, 0.15];

/// A point on a rim of the level and the point on full detail's rim that it should be at, in bind space.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RimPair {
    /// Triangle of the level.
    pub triangle: u32,
    /// Weights of its corners.
    pub weights: [f32; 3],
    /// From full detail to the level, metres of bind space.
    pub offset: [f32; 3],
    pub contact: Contact,
    /// What it counts next to the pairs of the surfaces.
    pub share: f32,
}

/// Points along the rims of full detail, and the edges of the level that they look for.
pub(crate) struct Rims {
    /// For each chart that has both: points, then edges of the level as triangle and corner.
    charts: Vec<(Vec<RimPoint>, Vec<(u32, u32)>)>,
    share: f32,
    /// Strips narrower than this count by the square of their width, metres.
    narrow: f32,
    /// Further apart, squared, a rim has no counterpart.
    reach_squared: f32,
}

/// A point on a rim of full detail.
#[derive(Clone, Copy)]
struct RimPoint {
    place: [f32; 3],
    /// What a strip of the wrong colour costs there, for each metre that it is wide.
    strip: f32,
}

impl Rims {
    pub fn new(full: &FullDetail<'_>, shape: &Shape) -> Self {
        let mut edges: Vec<(u32, usize, usize, u32)> = Vec::with_capacity(shape.triangles.len() * 3);
        for t in 0..shape.triangles.len() {
            let corners = shape.corner_places(t);
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                edges.push((full.charts.of_triangle[t], a.min(b), a.max(b), (t * 3 + i) as u32));
            }
        }
        edges.sort_unstable();
        let single: Vec<(u32, u32)> = edges
            .chunk_by(|x, y| (x.0, x.1, x.2) == (y.0, y.1, y.2))
            .filter(|group| group.len() == 1)
            .map(|group| (group[0].0, group[0].3))
            .collect();
        let area = total_area(full.mesh.positions, &full.triangles);
        // The mean edge of the level, as if its triangles were even.
        let edge = (area / shape.triangles.len().max(1) as f64 * 2.3).sqrt();
        let place = |v: u32| full.mesh.positions[v as usize];
        let length = |ends: &[u32; 2]| {
            let along = sub(place(ends[1]), place(ends[0]));
            f64::from(dot(along, along)).sqrt()
        };
        let mut rim_edges = full.charts.rim_edges.clone();
        rim_edges.sort_by_key(|e| e.chart);
        let contrasts = find_contrasts(full, &rim_edges);
        let rim_edges: Vec<(RimEdge, f32)> = rim_edges.into_iter().zip(contrasts).collect();
        let total: f64 = rim_edges.iter().map(|(e, _)| length(&e.ends)).sum();
        let step = (edge / POINTS_PER_EDGE).max(total / MOST_POINTS);
        let per_area = if area > 0.0 { step / area * full.scale_squared() } else { 0.0 };
        let metres = color_metres(full.mesh);
        let strip = (metres * metres * per_area) as f32;
        let mut charts = Vec::new();
        if step > 0.0 && step.is_finite() && area > 0.0 {
            let mut rest = single.as_slice();
            for group in rim_edges.chunk_by(|a, b| a.0.chart == b.0.chart) {
                let chart = group[0].0.chart;
                let skip = rest.partition_point(|e| e.0 < chart);
                let count = rest[skip..].partition_point(|e| e.0 == chart);
                let own: Vec<(u32, u32)> = rest[skip..skip + count].iter().map(|e| (e.1 / 3, e.1 % 3)).collect();
                rest = &rest[skip + count..];
                if own.is_empty() {
                    continue;
                }
                let mut points = Vec::new();
                let mut next = step / 2.0;
                for (RimEdge { ends, .. }, contrast) in group {
                    let length = length(ends);
                    let (a, b) = (place(ends[0]), place(ends[1]));
                    while next < length {
                        let s = (next / length) as f32;
                        let place = [0, 1, 2].map(|i| a[i] + s * (b[i] - a[i]));
                        points.push(RimPoint { place, strip: strip * contrast });
                        next += step;
                    }
                    next -= length;
                }
                charts.push((points, own));
            }
        }
        let share = (RIM_SHARE * edge * per_area) as f32;
        let reach = REACH * edge;
        Self { charts, share, narrow: (NARROW * edge) as f32, reach_squared: (reach * reach) as f32 }
    }

    /// The pairs of the shape, and what they cost.
    pub fn pair(&self, shape: &Shape) -> (Vec<RimPair>, f64) {
        let bind = shape.bind();
        let (mut pairs, mut sum) = (Vec::new(), 0.0);
        for (points, edges) in &self.charts {
            let threads: Vec<[u32; 3]> = edges
                .iter()
                .map(|&(t, i)| {
                    let corners = shape.triangles[t as usize];
                    let (a, b) = (corners[i as usize], corners[(i as usize + 1) % 3]);
                    [a, b, b]
                })
                .collect();
            let mut tree = ClosestTriangles::new(&bind, &threads);
            tree.refit(&bind, &threads);
            let mut last = None;
            for &RimPoint { place: point, strip } in points {
                let Some(hit) = tree.closest_point(point, &bind, &threads, None, last) else { continue };
                last = Some(hit.triangle);
                let off = hit.distance_squared.min(self.reach_squared).sqrt();
                let width = off - self.narrow * libm::logf(1.0 + off / self.narrow);
                sum += f64::from(self.share * off * off + strip * width);
                if hit.distance_squared > self.reach_squared {
                    continue;
                }
                // A cost by the width, as a weight of the square: half of one over it.
                let share = self.share + 0.5 * strip / (off + self.narrow);
                let corners = threads[hit.triangle as usize].map(|v| bind[v as usize]);
                let (t, i) = edges[hit.triangle as usize];
                let mut weights = [0.0; 3];
                weights[i as usize] = hit.weights[0];
                weights[(i as usize + 1) % 3] = hit.weights[1] + hit.weights[2];
                let offset = sub(super::pairs::mix(corners, hit.weights), point);
                pairs.push(RimPair { triangle: t, weights, offset, contact: contact(&hit, corners), share });
            }
        }
        (pairs, sum)
    }
}

/// Squared difference of the colours on the two sides of each rim edge, stressed where both are plain; 0 where nothing is on the other side, and where nobody
/// knows the colours.
fn find_contrasts(full: &FullDetail<'_>, rim_edges: &[RimEdge]) -> Vec<f32> {
    let place = |v: u32| full.mesh.positions[v as usize].map(zero_signless_bits);
    let key = |(i, edge): (usize, &RimEdge)| {
        let [a, b] = edge.ends.map(place);
        (a.min(b), a.max(b), i)
    };
    let mut sides: Vec<([u32; 3], [u32; 3], usize)> = rim_edges.iter().enumerate().map(key).collect();
    sides.sort_unstable();
    let beside = |edge: RimEdge| {
        let corners = full.triangles[edge.triangle as usize];
        let at = |v: u32| if edge.ends.contains(&v) { BESIDE[0] } else { BESIDE[1] };
        full.color_in(edge.triangle, corners.map(at))
    };
    let mut contrasts = vec![0.0; rim_edges.len()];
    for group in sides.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let first = beside(rim_edges[group[0].2]);
        let difference = |side: &([u32; 3], [u32; 3], usize)| {
            let off = sub(beside(rim_edges[side.2]), first);
            dot(off, off) / 3.0
        };
        let most = group[1..].iter().map(difference).fold(0.0, f32::max);
        let plain = group.iter().all(|side| full.is_plain(rim_edges[side.2].triangle));
        let most = if plain { most * PLAIN_FACTOR } else { most };
        group.iter().for_each(|side| contrasts[side.2] = most);
    }
    contrasts
}

fn total_area(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> f64 {
    let area = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| positions[v as usize]);
        let n = cross(sub(b, a), sub(c, a));
        f64::from(dot(n, n)).sqrt() / 2.0
    };
    triangles.iter().map(area).sum()
}
