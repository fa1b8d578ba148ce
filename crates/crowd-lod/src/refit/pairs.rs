//! Finds, for points on both surfaces, the closest point on the other: what the fit pulls together.
//!
//! A point looks in its own layer, as long as that has a triangle left: of two shells that lie close, as the white of an eye under
//! its cornea, the wrong one is often nearer, and a fit to it would mix them.

use super::full_detail::FullDetail;
use super::shape::Shape;
use crate::Mat3x4;
use crate::behind::diagonal;
use crate::closest::{ClosestTriangles, Hit, NodeGroups};
use crate::measure::{Sample, spread_samples};
use crate::quadrics::{cross, dot, sub};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};

/// Distance within which two surfaces count as one, in shares of the diagonal: of two that lie on each other a point keeps to its own.
const SAME_PLACE: f32 = 1.0e-5;

/// How many times as much a point of full detail counts that the level lies below: what a silhouette misses is worse to see than what it gains,
/// and limbs, which are all silhouette, thin (0066).
const BELOW: f32 = 1.5;

/// Which triangles show alike, where a point keeps to those that show what its own triangle does if they are as close as others.
struct Looks {
    of_triangle: Vec<u32>,
    /// Those of the nodes of full detail's trees, and of the level's.
    full: NodeGroups,
    level: NodeGroups,
    /// Square of [`SAME_PLACE`] in metres.
    same_squared: f32,
}

impl Looks {
    fn new(full: &FullDetail<'_>, shape: &Shape, tree: &ClosestTriangles) -> Option<Self> {
        let look = |t: usize| (full.charts.of_triangle[t], full.mesh.colors[full.triangles[t][0] as usize]);
        let mut numbers: BTreeMap<(u32, [u8; 4]), u32> = BTreeMap::new();
        for t in 0..full.triangles.len() {
            let next = numbers.len() as u32;
            numbers.entry(look(t)).or_insert(next);
        }
        let of_triangle: Vec<u32> = (0..full.triangles.len()).map(|t| numbers[&look(t)]).collect();
        let same = SAME_PLACE * diagonal(full.mesh.positions);
        Some(Self {
            full: full.frames.first()?.tree.group_by(of_triangle.clone()),
            level: tree.group_by(of_triangle[..shape.triangles.len()].to_vec()),
            of_triangle,
            same_squared: same * same,
        })
    }

    /// `hit`, or what `search` finds among the triangles that look like `own` if that is as close.
    fn keep_to(
        &self,
        groups: &NodeGroups,
        own: u32,
        hit: Hit,
        search: impl Fn(Option<(&NodeGroups, u32)>, f32) -> Option<Hit>,
    ) -> Hit {
        let look = self.of_triangle[own as usize];
        if self.of_triangle[hit.triangle as usize] == look {
            return hit;
        }
        let farthest = hit.distance_squared + self.same_squared;
        let alike = search(Some((groups, look)), farthest);
        alike.filter(|alike| alike.distance_squared <= farthest).unwrap_or(hit)
    }
}

/// What the closest point lies on: along what it may slide without the distance growing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Contact {
    /// A face with this unit normal.
    Face([f32; 3]),
    /// An edge with this unit direction.
    Edge([f32; 3]),
    /// A corner.
    Corner,
}

/// A point on the level and the point on full detail that it should be at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pair {
    /// Frame, an index into those of [`FullDetail`].
    pub frame: u32,
    /// Triangle of the level.
    pub triangle: u32,
    /// Weights of its corners.
    pub weights: [f32; 3],
    /// Triangle of full detail.
    pub full_triangle: u32,
    /// Weights of its corners.
    pub full_weights: [f32; 3],
    /// From full detail to the level, metres.
    pub offset: [f32; 3],
    pub contact: Contact,
    /// Share in the mean: all pairs of a side sum to about 1, where none counts more than others.
    pub share: f32,
}

/// Points on both surfaces, the same ones in every round, each watched in one frame.
pub(crate) struct Probes {
    full: Vec<Sample>,
    level: Vec<Sample>,
    tree: ClosestTriangles,
    /// Layers of the tree's nodes.
    groups: NodeGroups,
    /// Whether each layer has a triangle left.
    alive: Vec<bool>,
    /// For each point of either side, the triangle that was closest when it looked last: where the next search starts, whatever it finds.
    nearest: [Vec<AtomicU32>; 2],
}

/// No triangle was closest yet.
const NONE_YET: u32 = u32::MAX;

impl Probes {
    /// Spreads `count` points over each side.
    pub fn new(full: &FullDetail<'_>, shape: &Shape, count: u32) -> Self {
        let bind = shape.bind();
        let tree = ClosestTriangles::new(&bind, &shape.triangles);
        // The level's triangles are the first of full detail's.
        let layers = full.layers[..shape.triangles.len()].to_vec();
        let mut alive = vec![false; full.layers.iter().max().map_or(0, |&most| most as usize + 1)];
        layers.iter().for_each(|&layer| alive[layer as usize] = true);
        let sides = [full.spread(count), spread_samples(&bind, &shape.triangles, count)];
        let nearest = sides.each_ref().map(|side| side.iter().map(|_| AtomicU32::new(NONE_YET)).collect());
        let [full, level] = sides;
        Self { full, level, groups: tree.group_by(layers), tree, alive, nearest }
    }

    /// Points a side.
    pub fn count(&self) -> u32 {
        self.full.len().max(self.level.len()) as u32
    }

    /// All pairs of the shape with its mean squared distance over both sides. `facing`: only faces that look the same way
    /// are paired, otherwise points of full detail that the level lies below have more of a share.
    pub fn pair(
        &self,
        full: &FullDetail<'_>,
        shape: &Shape,
        matrices: &[Vec<Mat3x4>],
        facing: bool,
    ) -> (Vec<Pair>, f64) {
        self.pair_all(full, shape, matrices, facing, None)
    }

    /// Pairs of faces that look the same way, of whatever layers; of several at one place, those that show alike.
    pub fn pair_seen(&self, full: &FullDetail<'_>, shape: &Shape, matrices: &[Vec<Mat3x4>]) -> Vec<Pair> {
        let Some(looks) = Looks::new(full, shape, &self.tree) else { return Vec::new() };
        self.pair_all(full, shape, matrices, true, Some(&looks)).0
    }

    fn pair_all(
        &self,
        full: &FullDetail<'_>,
        shape: &Shape,
        matrices: &[Vec<Mat3x4>],
        facing: bool,
        looks: Option<&Looks>,
    ) -> (Vec<Pair>, f64) {
        let by_frame: Vec<(Vec<Pair>, f64)> = (0..full.frames.len())
            .into_par_iter()
            .map(|f| self.pair_frame(full, shape, &matrices[f], f, facing, looks))
            .collect();
        let sum = by_frame.iter().map(|b| b.1).sum::<f64>();
        (by_frame.into_iter().flat_map(|b| b.0).collect(), sum / 2.0)
    }

    fn pair_frame(
        &self,
        full: &FullDetail<'_>,
        shape: &Shape,
        matrices: &[Mat3x4],
        f: usize,
        facing: bool,
        looks: Option<&Looks>,
    ) -> (Vec<Pair>, f64) {
        let frame = &full.frames[f];
        let posed = shape.pose(matrices);
        let mut tree = self.tree.clone();
        tree.refit(&posed, &shape.triangles);
        let step = full.frames.len();
        let share = |count: usize| (frame.weight * step as f64 / count.max(1) as f64) as f32;
        let to_level = share(self.full.len());
        let from_full = |sample: &Sample, first: Option<u32>| {
            let (corners, weights, point) = place(sample, &frame.posed, &full.triangles);
            let outward = normal(corners);
            let facing = facing.then_some(outward);
            let layer = full.layers[sample.triangle as usize];
            let own = (looks.is_none() && self.alive[layer as usize]).then_some((&self.groups, layer));
            let search = |own: Option<(&NodeGroups, u32)>, farthest| {
                tree.closest_point_near(point, &posed, &shape.triangles, facing, first, own, farthest)
            };
            let hit = search(own, f32::INFINITY)?;
            let hit = looks.map_or(hit, |looks| looks.keep_to(&looks.level, sample.triangle, hit, search));
            let corners = shape.triangles[hit.triangle as usize].map(|v| posed[v as usize]);
            let at = mix(corners, hit.weights);
            let offset = sub(at, point);
            let below = facing.is_none() && dot(offset, outward) < 0.0;
            let pair = Pair {
                frame: f as u32,
                triangle: hit.triangle,
                weights: hit.weights,
                full_triangle: sample.triangle,
                full_weights: weights,
                offset,
                contact: contact(&hit, corners),
                share: if below { BELOW * to_level } else { to_level },
            };
            Some((pair, hit.triangle, to_level * hit.distance_squared))
        };
        let to_full = share(self.level.len());
        let from_level = |sample: &Sample, first: Option<u32>| {
            let (corners, weights, point) = place(sample, &posed, &shape.triangles);
            let facing = facing.then(|| normal(corners));
            let own = looks.is_none().then(|| (&full.groups, full.layers[sample.triangle as usize]));
            let search = |own: Option<(&NodeGroups, u32)>, farthest| {
                frame.tree.closest_point_near(point, &frame.posed, &full.triangles, facing, first, own, farthest)
            };
            let hit = search(own, f32::INFINITY)?;
            let hit = looks.map_or(hit, |looks| looks.keep_to(&looks.full, sample.triangle, hit, search));
            let corners = full.triangles[hit.triangle as usize].map(|v| frame.posed[v as usize]);
            let pair = Pair {
                frame: f as u32,
                triangle: sample.triangle,
                weights,
                full_triangle: hit.triangle,
                full_weights: hit.weights,
                offset: sub(point, mix(corners, hit.weights)),
                contact: contact(&hit, corners),
                share: to_full,
            };
            Some((pair, hit.triangle, to_full * hit.distance_squared))
        };
        let (to_level, to_full) = rayon::join(
            || look_up(&self.full, &self.nearest[0], (f, step), from_full),
            || look_up(&self.level, &self.nearest[1], (f, step), from_level),
        );
        let found = to_level.iter().chain(&to_full).flatten();
        let sum = found.clone().map(|(_, squared)| f64::from(*squared)).sum();
        (found.map(|(pair, _)| *pair).collect(), sum)
    }
}

/// Points that one thread looks up in turn at least, where few frames leave cores idle.
const IN_TURN: usize = 4096;

/// The pairs of one frame's share of the points of a side, with what each adds to the mean squared distance, in the order of the points: so many
/// lists as threads may have taken part. `nearest`: from [`Probes`].
fn look_up(
    samples: &[Sample],
    nearest: &[AtomicU32],
    (first, step): (usize, usize),
    look: impl Fn(&Sample, Option<u32>) -> Option<(Pair, u32, f32)> + Sync,
) -> Vec<Vec<(Pair, f32)>> {
    let (samples, nearest) = (&samples[first.min(samples.len())..], &nearest[first.min(nearest.len())..]);
    let in_turn = |(samples, nearest): (&[Sample], &[AtomicU32])| {
        let mut last = None;
        let one = |(sample, nearest): (&Sample, &AtomicU32)| {
            // The surfaces hardly move between two calls: what was closest is so again, or nearly. Each point is looked up by one thread.
            let start = Some(nearest.load(Ordering::Relaxed)).filter(|&known| known != NONE_YET).or(last);
            let (pair, closest, squared) = look(sample, start)?;
            last = Some(closest);
            nearest.store(closest, Ordering::Relaxed);
            Some((pair, squared))
        };
        samples.iter().zip(nearest).step_by(step).filter_map(one).collect()
    };
    let points = IN_TURN * step;
    samples.par_chunks(points).zip(nearest.par_chunks(points)).map(in_turn).collect()
}

fn place(sample: &Sample, posed: &[[f32; 3]], triangles: &[[u32; 3]]) -> ([[f32; 3]; 3], [f32; 3], [f32; 3]) {
    let corners = triangles[sample.triangle as usize].map(|v| posed[v as usize]);
    let [s, t] = sample.weights;
    let weights = [s, t, 1.0 - s - t];
    (corners, weights, mix(corners, weights))
}

pub(crate) fn contact(hit: &Hit, corners: [[f32; 3]; 3]) -> Contact {
    let unit = |v: [f32; 3]| {
        let length = dot(v, v).sqrt();
        (length > f32::MIN_POSITIVE).then(|| v.map(|c| c / length))
    };
    let edge = |i: usize, j: usize| unit(sub(corners[j], corners[i])).map_or(Contact::Corner, Contact::Edge);
    match hit.weights.map(|w| w > 0.0) {
        [true, true, true] => unit(normal(corners)).map_or(Contact::Corner, Contact::Face),
        [true, true, false] => edge(0, 1),
        [false, true, true] => edge(1, 2),
        [true, false, true] => edge(2, 0),
        _ => Contact::Corner,
    }
}

fn normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    cross(sub(b, a), sub(c, a))
}

/// A point by the weights of three corners.
pub(crate) fn mix(corners: [[f32; 3]; 3], weights: [f32; 3]) -> [f32; 3] {
    [0, 1, 2].map(|i| corners[0][i] * weights[0] + corners[1][i] * weights[1] + corners[2][i] * weights[2])
}
