//! Holds the rims of a level's patches to those of full detail: seams, open borders and where two colours meet.
//!
//! Where two colours meet, a rim that is off by some way shows a strip as wide of the wrong one: that costs by the width, not by its
//! square, as much as the colours differ. Both ways: full detail's rims look for the level's, and the level's for full detail's, or a spur of
//! the level that lies beside no rim would cost nothing.

use super::full_detail::FullDetail;
use super::pairs::{Contact, contact, mix};
use super::patches::{Patches, RimEdge};
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
const PLAIN_FACTOR: f32 = 10.0;
/// The same at coarse levels, where distances have grown more than colours: such that colours count this share of what distances do, as
/// far as they go apart before the fit; at most [`MOST_PLAIN_FACTOR`].
const BALANCE: f64 = 0.25;
const MOST_PLAIN_FACTOR: f32 = 128.0;
/// What a strip counts that a rim of the level shows, next to one at a rim of full detail.
const BACK_SHARE: f32 = 1.5;
/// Where the colour beside an edge is looked up: weights of its ends, and of the triangle's third corner.
const BESIDE: [f32; 2] = [0.425, 0.15];

/// Points on an edge of the level at most.
const MOST_STEPS: f32 = 64.0;

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

/// The rims of full detail and those of the level, which look for each other.
pub(crate) struct Rims {
    /// One for each patch that has a rim on both sides.
    patches: Vec<PatchRim>,
    /// Between two points, metres.
    step: f32,
    share: f32,
    /// Strips narrower than this count by the square of their width, metres.
    narrow: f32,
    /// Further apart, squared, a rim has no counterpart.
    reach_squared: f32,
}

/// The rim of a patch.
struct PatchRim {
    points: Vec<RimPoint>,
    /// Edges of the level, as triangle and corner.
    own: Vec<(u32, u32)>,
    /// Edges of full detail as triangles of no width, and what a strip costs there for each metre that it is wide.
    ends: Vec<[f32; 3]>,
    threads: Vec<[u32; 3]>,
    tree: ClosestTriangles,
    strips: Vec<f32>,
}

/// A point on a rim of full detail.
#[derive(Clone, Copy)]
struct RimPoint {
    place: [f32; 3],
    /// What a strip of the wrong colour costs there, for each metre that it is wide.
    strip: f32,
}

impl Rims {
    /// `plain_factor`: from [`find_plain_factor`].
    pub fn new(full: &FullDetail<'_>, shape: &Shape, patches: &Patches, plain_factor: f32) -> Self {
        let mut edges: Vec<(u32, usize, usize, u32)> = Vec::with_capacity(shape.triangles.len() * 3);
        for t in 0..shape.triangles.len() {
            let corners = shape.corner_places(t);
            for i in 0..3 {
                let (a, b) = (corners[i], corners[(i + 1) % 3]);
                edges.push((patches.of_level[t], a.min(b), a.max(b), (t * 3 + i) as u32));
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
        let rim_edges = patches.rim_edges(full);
        let contrasts = find_contrasts(full, &rim_edges, plain_factor);
        let rim_edges: Vec<(RimEdge, f32)> = rim_edges.into_iter().zip(contrasts).collect();
        let total: f64 = rim_edges.iter().map(|(e, _)| length(&e.ends)).sum();
        let step = (edge / POINTS_PER_EDGE).max(total / MOST_POINTS);
        let per_area = if area > 0.0 { step / area * full.scale_squared() } else { 0.0 };
        let metres = color_metres(full.mesh);
        let strip = (metres * metres * per_area) as f32;
        let mut patches = Vec::new();
        if step > 0.0 && step.is_finite() && area > 0.0 {
            let mut rest = single.as_slice();
            for group in rim_edges.chunk_by(|a, b| a.0.patch == b.0.patch) {
                let patch = group[0].0.patch;
                let skip = rest.partition_point(|e| e.0 < patch);
                let count = rest[skip..].partition_point(|e| e.0 == patch);
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
                let ends: Vec<[f32; 3]> = group.iter().flat_map(|(e, _)| e.ends.map(place)).collect();
                let threads: Vec<[u32; 3]> = (0..group.len() as u32).map(|i| [2 * i, 2 * i + 1, 2 * i + 1]).collect();
                let mut tree = ClosestTriangles::new(&ends, &threads);
                tree.refit(&ends, &threads);
                let strips = group.iter().map(|(_, contrast)| strip * contrast).collect();
                patches.push(PatchRim { points, own, ends, threads, tree, strips });
            }
        }
        let share = (RIM_SHARE * edge * per_area) as f32;
        let reach = REACH * edge;
        Self {
            patches,
            step: step as f32,
            share,
            narrow: (NARROW * edge) as f32,
            reach_squared: (reach * reach) as f32,
        }
    }

    /// The pairs of the shape, and what they cost.
    pub fn pair(&self, shape: &Shape) -> (Vec<RimPair>, f64) {
        let bind = shape.bind();
        let (mut pairs, mut sum) = (Vec::new(), 0.0);
        for patch in &self.patches {
            self.pair_full(patch, shape, &bind, &mut pairs, &mut sum);
            self.pair_level(patch, shape, &bind, &mut pairs, &mut sum);
        }
        (pairs, sum)
    }

    /// From full detail's rim to the level's.
    fn pair_full(&self, patch: &PatchRim, shape: &Shape, bind: &[[f32; 3]], pairs: &mut Vec<RimPair>, sum: &mut f64) {
        let thread = |&(t, i): &(u32, u32)| {
            let corners = shape.triangles[t as usize];
            let (a, b) = (corners[i as usize], corners[(i as usize + 1) % 3]);
            [a, b, b]
        };
        let threads: Vec<[u32; 3]> = patch.own.iter().map(thread).collect();
        let mut tree = ClosestTriangles::new(bind, &threads);
        tree.refit(bind, &threads);
        let mut last = None;
        for &RimPoint { place: point, strip } in &patch.points {
            let Some(hit) = tree.closest_point(point, bind, &threads, None, last) else { continue };
            last = Some(hit.triangle);
            let Some(share) = self.weigh(hit.distance_squared, self.share, strip, sum) else { continue };
            let corners = threads[hit.triangle as usize].map(|v| bind[v as usize]);
            let (t, i) = patch.own[hit.triangle as usize];
            let mut weights = [0.0; 3];
            weights[i as usize] = hit.weights[0];
            weights[(i as usize + 1) % 3] = hit.weights[1] + hit.weights[2];
            let offset = sub(mix(corners, hit.weights), point);
            pairs.push(RimPair { triangle: t, weights, offset, contact: contact(&hit, corners), share });
        }
    }

    /// From the level's rim to full detail's: only what shows, strips between colours.
    fn pair_level(&self, patch: &PatchRim, shape: &Shape, bind: &[[f32; 3]], pairs: &mut Vec<RimPair>, sum: &mut f64) {
        if patch.strips.iter().all(|&strip| strip <= 0.0) {
            return;
        }
        let mut last = None;
        for &(t, i) in &patch.own {
            let corners = shape.triangles[t as usize];
            let (i, j) = (i as usize, (i as usize + 1) % 3);
            let [a, b] = [i, j].map(|k| bind[corners[k] as usize]);
            let along = sub(b, a);
            let steps = dot(along, along).sqrt() / self.step;
            if !steps.is_finite() {
                continue;
            }
            let count = steps.ceil().clamp(1.0, MOST_STEPS);
            for k in 0..count as u32 {
                let s = (k as f32 + 0.5) / count;
                let mut weights = [0.0; 3];
                (weights[i], weights[j]) = (1.0 - s, s);
                let point = [0, 1, 2].map(|axis| a[axis] + s * along[axis]);
                let hit = patch.tree.closest_point(point, &patch.ends, &patch.threads, None, last);
                let Some(hit) = hit else { continue };
                last = Some(hit.triangle);
                let strip = patch.strips[hit.triangle as usize] * BACK_SHARE * steps / count;
                if strip <= 0.0 {
                    continue;
                }
                let Some(share) = self.weigh(hit.distance_squared, 0.0, strip, sum) else { continue };
                let corners = patch.threads[hit.triangle as usize].map(|v| patch.ends[v as usize]);
                let offset = sub(point, mix(corners, hit.weights));
                pairs.push(RimPair { triangle: t, weights, offset, contact: contact(&hit, corners), share });
            }
        }
    }

    /// Adds what a pair costs, and gives back what it weighs; `None` where it is too far apart to pull.
    fn weigh(&self, distance_squared: f32, share: f32, strip: f32, sum: &mut f64) -> Option<f32> {
        let off = distance_squared.min(self.reach_squared).sqrt();
        let width = off - self.narrow * libm::logf(1.0 + off / self.narrow);
        *sum += f64::from(share * off * off + strip * width);
        // A cost by the width, as a weight of the square: half of one over it.
        (distance_squared <= self.reach_squared).then(|| share + 0.5 * strip / (off + self.narrow))
    }
}

/// How many times as much a strip costs between plain colours. `mean_squared`: distance of the level, both ways, before the fit; `colors`: mean
/// squared difference of the colours that it shows, of 1 between black and white.
pub(crate) fn find_plain_factor(full: &FullDetail<'_>, mean_squared: f64, colors: f64) -> f32 {
    let metres = color_metres(full.mesh);
    let even = BALANCE * mean_squared / (colors * metres * metres);
    if even.is_finite() { (even as f32).clamp(PLAIN_FACTOR, MOST_PLAIN_FACTOR) } else { PLAIN_FACTOR }
}

/// Squared difference of the colours on the two sides of each rim edge, stressed where both are plain; 0 where nothing is on the other side, and where nobody
/// knows the colours.
fn find_contrasts(full: &FullDetail<'_>, rim_edges: &[RimEdge], plain_factor: f32) -> Vec<f32> {
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
        let most = if plain { most * plain_factor } else { most };
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{PlainGrays, TestPoses, grid, quick};
    use crate::{Appearance, LodMesh, level_mesh, simplify};

    /// Full detail of a plane of two gray halves, and what its rims are as a level that is the same.
    fn with_halves(see: impl Fn(&FullDetail<'_>, &Shape)) {
        let mut mesh = grid(8, 4, |_, _| 0.0, |_, _| false);
        let right = |t: &[u32; 3]| t.iter().all(|&v| mesh.positions[v as usize][0] >= 4.0);
        mesh.materials = mesh.triangles.iter().map(|t| u16::from(right(t))).collect();
        let appearance = Appearance { textures: Some(&PlainGrays), ..Appearance::default() };
        let lod_mesh = LodMesh { appearance, ..mesh.mesh() };
        let poses = TestPoses::rest();
        let order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
        let level = level_mesh(&lod_mesh, &order, order.levels.last().expect("full detail"));
        see(&FullDetail::new(&lod_mesh, &poses.poses(), &order, 1), &Shape::new(&level));
    }

    #[test]
    fn a_border_that_moved_costs_and_is_drawn_back() {
        with_halves(|full, shape| {
            let rims = Rims::new(full, shape, &Patches::new(full, shape.triangles.len()), PLAIN_FACTOR);
            let moved = |by: f32| {
                let mut shape = shape.clone();
                let place = shape.places.iter_mut().find(|p| **p == [4.0, 2.0, 0.0]).expect("in the middle");
                place[0] += by;
                rims.pair(&shape)
            };
            let cost = |by| moved(by).1;
            assert!(cost(0.0) < 1.0e-9 && cost(0.1) > 1.0e-9 && cost(0.2) > 1.5 * cost(0.1));
            let pairs = moved(0.2).0;
            let off: Vec<_> = pairs.iter().filter(|pair| pair.offset[0].abs() > 0.01).collect();
            assert!(!off.is_empty() && off.iter().all(|pair| pair.offset[0] > 0.0), "{off:?}");
        });
    }

    #[test]
    fn a_spur_beside_no_rim_costs_what_it_shows() {
        with_halves(|full, shape| {
            let mut patches = Patches::new(full, shape.triangles.len());
            let before = Rims::new(full, shape, &patches, PLAIN_FACTOR).pair(shape).1;
            // A triangle in the middle of the left half shows the colour of the right one.
            let inner = (0..shape.triangles.len()).find(|&t| {
                let places = shape.corner_places(t).map(|p| shape.places[p]);
                places.iter().all(|p| (1.0..=3.0).contains(&p[0]) && (1.0..=3.0).contains(&p[1]))
            });
            let inner = inner.expect("in the middle");
            let right = full.materials.iter().position(|&m| m == 1).expect("the other half");
            patches.repaint(full, &[(inner, full.plain_look(right as u32).expect("plain"))]);
            let rims = Rims::new(full, shape, &patches, PLAIN_FACTOR);
            let spur = rims.pair(shape).1 - before;
            // Three edges of 1, 1 and 1.4 m, seen from two patches, each as far off as counts at most; not from where the outer border, which
            // shows nothing, is nearer than the other colour.
            let far = rims.reach_squared.sqrt();
            let width = far - rims.narrow * libm::logf(1.0 + far / rims.narrow);
            let strip = rims.patches[0].strips.iter().fold(0.0_f32, |a, &b| a.max(b));
            let most = f64::from(strip * width / rims.step) * f64::from(BACK_SHARE) * 3.5 * 2.0;
            assert!(spur > 0.5 * most && spur < 1.01 * most, "{spur} {most}");
        });
    }

    #[test]
    fn plain_colors_count_more_where_distances_have_grown_more() {
        with_halves(|full, _| {
            let metres = color_metres(full.mesh);
            let factor = |balance: f64| find_plain_factor(full, balance * metres * metres, 1.0);
            assert_eq!(factor(0.0), PLAIN_FACTOR);
            assert_eq!(factor(100.0), 25.0);
            assert_eq!(factor(1.0e6), MOST_PLAIN_FACTOR);
            assert_eq!(find_plain_factor(full, 1.0, 0.0), PLAIN_FACTOR, "no colour is off");
        });
    }
}
