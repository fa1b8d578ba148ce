//! Turns the normals of a level towards those of full detail.

use super::fit_attributes::{REWEIGHT_COUNT, distance, interpolate, number_by_key, spread_attribute};
use super::full_detail::FullDetail;
use super::pairs::{Pair, mix};
use super::shape::Shape;
use crate::LevelMesh;
use crate::quadrics::dot;
use crate::split_seams::zero_signless_bits;

/// Shorter sums of normals point nowhere: the vertex keeps its own.
const LEAST_LENGTH: f64 = 1.0e-3;

/// Errors well below this (about 3 degrees) count by their square, larger ones by their size.
const SMALL_ERROR: f64 = 0.05;

/// For each vertex the normal that, interpolated over the level's triangles, is closest to full detail's.
///
/// Vertices of one place that had the same normal keep the same one: smooth seams stay smooth, and hard edges, with a
/// vertex for each side, hard. `pairs`: of faces that look the same way.
pub(crate) fn fit_normals(full: &FullDetail<'_>, shape: &Shape, pairs: &[Pair], level: &LevelMesh) -> Vec<[f32; 3]> {
    let (groups, count) = number_by_key(level.normals.len(), |v| {
        (shape.skins[shape.skin_of[v] as usize].place, level.normals[v].map(zero_signless_bits))
    });
    let mut first = vec![[0.0; 3]; count];
    for (v, &g) in groups.iter().enumerate() {
        first[g as usize] = level.normals[v].map(f64::from);
    }
    let corners: Vec<[u32; 3]> = level.triangles.iter().map(|t| t.map(|v| groups[v as usize])).collect();
    let mut normals = first.clone();
    for _ in 0..REWEIGHT_COUNT {
        let now = normals;
        normals = spread_attribute(&corners, &first, pairs, |pair| {
            let at = full.triangles[pair.full_triangle as usize].map(|v| full.mesh.normals[v as usize]);
            let normal = mix(at, pair.full_weights);
            let length = dot(normal, normal).sqrt();
            let target = normal.map(|c| f64::from(c / length));
            let own = corners[pair.triangle as usize].map(|g| now[g as usize]);
            let error = distance(interpolate(own, pair.weights), target);
            (length > LEAST_LENGTH as f32).then_some((target, 1.0 / (error + SMALL_ERROR)))
        });
    }
    let mut out = level.normals.clone();
    for (v, &g) in groups.iter().enumerate() {
        let n = normals[g as usize];
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        if length > LEAST_LENGTH {
            out[v] = n.map(|c| (c / length) as f32);
        }
    }
    out
}
