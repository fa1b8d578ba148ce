//! Turns the normals of a level towards those of full detail.

use super::fit_attributes::{REWEIGHT_COUNT, distance, interpolate, number_by_key, spread_attribute};
use super::full_detail::FullDetail;
use super::pairs::{Pair, mix};
use super::shape::Shape;
use super::turn_normals::Aims;
use crate::quadrics::dot;
use crate::split_seams::zero_signless_bits;
use crate::{LevelMesh, Mat3x4};

/// Shorter sums of normals point nowhere: the vertex keeps its own.
const LEAST_LENGTH: f64 = 1.0e-3;

/// Errors well below this (about 3 degrees) count by their square, larger ones by their size.
const SMALL_ERROR: f64 = 0.05;

/// Normals that are fitted: one for the vertices of a place that have the same one, so that smooth seams stay smooth, and hard edges, with a vertex for each
/// side, hard.
pub(crate) struct Unknowns {
    /// Of each vertex.
    of_vertex: Vec<u32>,
    /// At the corners of each triangle.
    pub corners: Vec<[u32; 3]>,
    /// What they are before.
    first: Vec<[f64; 3]>,
}

impl Unknowns {
    pub fn new(shape: &Shape, level: &LevelMesh) -> Self {
        let (of_vertex, count) = number_by_key(level.normals.len(), |v| {
            (shape.skins[shape.skin_of[v] as usize].place, level.normals[v].map(zero_signless_bits))
        });
        let mut first = vec![[0.0; 3]; count];
        for (v, &g) in of_vertex.iter().enumerate() {
            first[g as usize] = level.normals[v].map(f64::from);
        }
        let corners = level.triangles.iter().map(|t| t.map(|v| of_vertex[v as usize])).collect();
        Self { of_vertex, corners, first }
    }

    /// `normals` for each vertex; where they point nowhere, what it had.
    fn to_vertices(&self, normals: &[[f64; 3]], level: &LevelMesh) -> Vec<[f32; 3]> {
        let one = |(&g, &before): (&u32, &[f32; 3])| unit(normals[g as usize]).map_or(before, |n| n.map(|c| c as f32));
        self.of_vertex.iter().zip(&level.normals).map(one).collect()
    }
}

/// For each vertex the normal that, interpolated over the level's triangles, is closest to full detail's, by least squares in bind space. `pairs`: of faces that
/// look the same way.
pub(crate) fn fit_normals(full: &FullDetail<'_>, shape: &Shape, pairs: &[Pair], level: &LevelMesh) -> Vec<[f32; 3]> {
    let unknowns = Unknowns::new(shape, level);
    unknowns.to_vertices(&spread_normals(full, pairs, &unknowns), level)
}

/// The same, then turned one by one until no angle in the frames can be made less.
pub(crate) fn fit_and_turn(
    full: &FullDetail<'_>,
    shape: &Shape,
    pairs: &[Pair],
    matrices: &[Vec<Mat3x4>],
    level: &LevelMesh,
) -> Vec<[f32; 3]> {
    let unknowns = Unknowns::new(shape, level);
    let spread = spread_normals(full, pairs, &unknowns);
    let fitted: Vec<[f64; 3]> =
        spread.iter().zip(&unknowns.first).map(|(&n, &before)| unit(n).unwrap_or(before)).collect();
    let aims = Aims::new(full, shape, &unknowns, matrices, pairs);
    let turned = aims.turn_normals(&unknowns.first, &fitted);
    unknowns.to_vertices(&turned, level)
}

fn spread_normals(full: &FullDetail<'_>, pairs: &[Pair], unknowns: &Unknowns) -> Vec<[f64; 3]> {
    let Unknowns { corners, first, .. } = unknowns;
    let mut normals = first.clone();
    for _ in 0..REWEIGHT_COUNT {
        let now = normals;
        normals = spread_attribute(corners, first, pairs, |pair| {
            let at = full.triangles[pair.full_triangle as usize].map(|v| full.mesh.normals[v as usize]);
            let normal = mix(at, pair.full_weights);
            let length = dot(normal, normal).sqrt();
            let target = normal.map(|c| f64::from(c / length));
            let own = corners[pair.triangle as usize].map(|g| now[g as usize]);
            let error = distance(interpolate(own, pair.weights), target);
            (length > LEAST_LENGTH as f32).then_some((target, 1.0 / (error + SMALL_ERROR)))
        });
    }
    normals
}

/// `None` for what is too short to point anywhere.
pub(crate) fn unit(v: [f64; 3]) -> Option<[f64; 3]> {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    (length.is_finite() && length > LEAST_LENGTH).then(|| v.map(|c| c / length))
}
