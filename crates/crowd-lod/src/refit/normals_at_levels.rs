//! The normals that suit the levels of an order, places as they are, in bind pose.
//!
//! A point of full detail is held against the level's triangles around what its own corners have become: no search, and what hangs
//! together stays together.

use super::fit_normals::fit_normals_to;
use super::pairs::{Contact, Pair, mix};
use super::shape::Shape;
use crate::behind::diagonal;
use crate::closest::closest_on_triangle;
use crate::measure::{Sample, spread_samples};
use crate::quadrics::{cross, dot, sub};
use crate::{CollapseOrder, Level, LodMesh, level_mesh};
use rayon::prelude::*;

/// Points for each triangle of a level, and how many at least and at most.
const POINTS_PER_TRIANGLE: u32 = 6;
const LEAST_POINTS: u32 = 2_000;
const MOST_POINTS: u32 = 60_000;
/// Triangles looked at around a corner: enough for all but hubs.
const SEARCHED_TRIANGLES: usize = 24;
/// Points further from the level than this share of the diagonal say nothing of it: they are of a part that has vanished.
const REACH_SHARE: f32 = 0.05;

/// Fits normals at one level after another.
pub(crate) struct NormalsAtLevels<'a> {
    mesh: &'a LodMesh<'a>,
    order: &'a CollapseOrder,
    /// The order's triangles, in vertices of `mesh`.
    triangles: Vec<[u32; 3]>,
    reach_squared: f32,
}

/// The normals of a level.
pub(crate) struct FittedNormals {
    /// Vertices of the order that the level's triangles use, rising.
    pub vertices: Vec<u32>,
    /// For each, its place; vertices that share one share the number.
    pub places: Vec<u32>,
    /// For each, the unit normal that comes closest to full detail's.
    pub normals: Vec<[f32; 3]>,
}

impl<'a> NormalsAtLevels<'a> {
    /// Gathers full detail.
    pub fn new(mesh: &'a LodMesh<'a>, order: &'a CollapseOrder) -> Self {
        let triangles: Vec<[u32; 3]> = order.triangle_source.iter().map(|&t| mesh.triangles[t as usize]).collect();
        let used: Vec<[f32; 3]> = triangles.as_flattened().iter().map(|&v| mesh.positions[v as usize]).collect();
        let reach = REACH_SHARE * diagonal(&used);
        Self { mesh, order, triangles, reach_squared: reach * reach }
    }

    /// The normals that a level should have. `settled`: for each vertex of the order, what it is in the level. `sources`: the input
    /// vertex whose normal it has by now; of vertices at one place, those with one normal get one.
    pub fn fit(&self, level: &Level, settled: &[u32], sources: &[u32]) -> FittedNormals {
        let mut level = level_mesh(self.mesh, self.order, level);
        level.normals = level.vertices.iter().map(|&v| self.mesh.normals[sources[v as usize] as usize]).collect();
        let shape = Shape::new(&level);
        let places: Vec<u32> = shape.skin_of.iter().map(|&skin| shape.skins[skin as usize].place).collect();
        let around = Around::new(&shape);
        let mut place_of = vec![u32::MAX; settled.len()];
        for (&v, &place) in level.vertices.iter().zip(&places) {
            place_of[v as usize] = place;
        }
        let count = (level.triangles.len() as u32).saturating_mul(POINTS_PER_TRIANGLE).clamp(LEAST_POINTS, MOST_POINTS);
        let samples = spread_samples(self.mesh.positions, &self.triangles, count);
        let found: Vec<Option<Pair>> = samples
            .par_iter()
            .map(|sample| {
                let corners = self.order.triangles[sample.triangle as usize];
                let near = corners.map(|v| around.at(place_of[settled[v as usize] as usize]));
                self.pair(&shape, sample, near.into_iter().flatten(), 1.0 / samples.len() as f32)
            })
            .collect();
        let pairs: Vec<Pair> = found.into_iter().flatten().collect();
        let normals = fit_normals_to(&shape, &pairs, &level, |pair| self.normal_at(pair));
        FittedNormals { vertices: level.vertices, places, normals }
    }

    /// A point with the closest one on some triangles that look the same way, its own first.
    fn pair<'b>(
        &self,
        shape: &Shape,
        sample: &Sample,
        near: impl Iterator<Item = &'b u32>,
        share: f32,
    ) -> Option<Pair> {
        let corners = self.triangles[sample.triangle as usize].map(|v| self.mesh.positions[v as usize]);
        let [s, t] = sample.weights;
        let full_weights = [s, t, 1.0 - s - t];
        let point = mix(corners, full_weights);
        let facing = normal(corners);
        let own = ((sample.triangle as usize) < shape.triangles.len()).then_some(sample.triangle);
        let mut best: Option<(f32, u32, [f32; 3])> = None;
        for triangle in own.into_iter().chain(near.copied()) {
            let corners = shape.corner_places(triangle as usize).map(|p| shape.places[p]);
            if dot(normal(corners), facing) > 0.0 {
                let (weights, distance_squared) = closest_on_triangle(point, corners);
                if best.is_none_or(|b| distance_squared < b.0) {
                    best = Some((distance_squared, triangle, weights));
                }
            }
        }
        let (_, triangle, weights) = best.filter(|b| b.0 <= self.reach_squared)?;
        Some(Pair {
            frame: 0,
            triangle,
            weights,
            full_triangle: sample.triangle,
            full_weights,
            offset: [0.0; 3],
            contact: Contact::Corner,
            share,
        })
    }

    fn normal_at(&self, pair: &Pair) -> [f32; 3] {
        let corners = self.triangles[pair.full_triangle as usize];
        mix(corners.map(|v| self.mesh.normals[v as usize]), pair.full_weights)
    }
}

/// The triangles around each place, not all at a hub.
struct Around {
    offsets: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    fn new(shape: &Shape) -> Self {
        let mut lists = vec![Vec::new(); shape.places.len()];
        for triangle in 0..shape.triangles.len() {
            for place in shape.corner_places(triangle) {
                if lists[place].len() < SEARCHED_TRIANGLES {
                    lists[place].push(triangle as u32);
                }
            }
        }
        let mut offsets = vec![0];
        offsets.extend(lists.iter().scan(0, |end, list: &Vec<u32>| {
            *end += list.len() as u32;
            Some(*end)
        }));
        Self { offsets, triangles: lists.concat() }
    }

    /// Nothing at a place that is none.
    fn at(&self, place: u32) -> &[u32] {
        let place = place as usize;
        match (self.offsets.get(place), self.offsets.get(place.saturating_add(1))) {
            (Some(&from), Some(&to)) => &self.triangles[from as usize..to as usize],
            _ => &[],
        }
    }
}

fn normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    cross(sub(b, a), sub(c, a))
}
