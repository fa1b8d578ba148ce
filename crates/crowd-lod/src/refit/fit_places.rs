//! Moves the places of a level by least squares over its pairs: linear, as the skinning stays as it is meanwhile.

use super::equations::{Local, add_damping, add_rim, local_equations, sort_by_triangle};
use super::full_detail::FullDetail;
use super::pairs::Pair;
use super::rims::RimPair;
use super::shape::Shape;
use super::solver::conjugate_gradients;
use crate::Mat3x4;
use crate::quadrics::{cross, dot, sub};
use rayon::prelude::*;

/// A place moves at most this share of its mean edge length in one round.
const STEP_LIMIT: f32 = 0.5;
/// A triangle may turn, in any frame, up to this cosine from where it was before the fit.
const TURN_COS: f32 = 0.2;

/// Where each place should go, metres, from where it is. `corner_uvs`: texture coordinates of each triangle's corners. `pulls`: the
/// pairs of the surfaces and of the rims. `held`: places that stay.
pub(crate) fn solve_places(
    full: &FullDetail<'_>,
    shape: &Shape,
    corner_uvs: &[[[f32; 2]; 3]],
    matrices: &[Vec<Mat3x4>],
    (pairs, rim_pairs): (&[Pair], &[RimPair]),
    held: &[bool],
) -> Vec<[f64; 3]> {
    let by_triangle = sort_by_triangle(shape.triangles.len(), pairs);
    let mut locals: Vec<Local> = by_triangle
        .par_iter()
        .enumerate()
        .map(|(t, pairs)| local_equations(full, shape, t, &corner_uvs[t], matrices, pairs))
        .collect();
    rim_pairs.iter().for_each(|pair| add_rim(&mut locals[pair.triangle as usize], pair));
    let corners: Vec<[usize; 3]> = (0..shape.triangles.len()).map(|t| shape.corner_places(t)).collect();
    add_damping(&mut locals);
    locals.iter_mut().zip(&corners).for_each(|(local, corners)| local.hold(corners.map(|p| held[p])));
    conjugate_gradients(&locals, &corners, shape.places.len())
}

/// The triangles before the fit, in every frame: what none may turn away from.
pub(crate) struct Uprights {
    /// `normals[frame][triangle]`, as long as twice the area.
    normals: Vec<Vec<[f32; 3]>>,
}

impl Uprights {
    pub fn new(shape: &Shape, matrices: &[Vec<Mat3x4>]) -> Self {
        Self { normals: matrices.par_iter().map(|m| face_normals(shape, m)).collect() }
    }

    /// Takes triangles whose corners changed as they are now.
    pub fn renew(&mut self, shape: &Shape, matrices: &[Vec<Mat3x4>], turned: &[(usize, [u32; 3])]) {
        self.normals.par_iter_mut().zip(matrices).for_each(|(normals, matrices)| {
            let now = face_normals(shape, matrices);
            turned.iter().for_each(|&(t, _)| normals[t] = now[t]);
        });
    }

    /// Triangles that have turned over in some frame.
    pub fn turned(&self, shape: &Shape, matrices: &[Vec<Mat3x4>]) -> Vec<usize> {
        let by_frame: Vec<Vec<usize>> = self
            .normals
            .par_iter()
            .zip(matrices)
            .map(|(before, matrices)| {
                let after = face_normals(shape, matrices);
                let turned = |&t: &usize| {
                    let (a, b) = (before[t], after[t]);
                    let lengths = (dot(a, a) * dot(b, b)).sqrt();
                    let upright = dot(a, b) > TURN_COS * lengths;
                    dot(a, a) > 0.0 && !upright
                };
                (0..before.len()).filter(turned).collect()
            })
            .collect();
        let mut all = by_frame.concat();
        all.sort_unstable();
        all.dedup();
        all
    }
}

fn face_normals(shape: &Shape, matrices: &[Mat3x4]) -> Vec<[f32; 3]> {
    let posed = shape.pose(matrices);
    let normal = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| posed[v as usize]);
        cross(sub(b, a), sub(c, a))
    };
    shape.triangles.iter().map(normal).collect()
}

/// Moves the places by `step` times `moves`, each no further than its edges allow and none so far that a triangle turns
/// over. `None` when that leaves nothing.
pub(crate) fn move_places(
    shape: &Shape,
    matrices: &[Vec<Mat3x4>],
    moves: &[[f64; 3]],
    step: f32,
    uprights: &Uprights,
) -> Option<Shape> {
    let edges = mean_edges(shape);
    let mut shares: Vec<f32> = moves
        .iter()
        .zip(&edges)
        .map(|(m, edge)| {
            let length = (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]).sqrt() as f32 * step;
            if !length.is_finite() {
                0.0
            } else if length > STEP_LIMIT * edge {
                step * STEP_LIMIT * edge / length
            } else {
                step
            }
        })
        .collect();
    let mut moved = shape.clone();
    for round in 0..12 {
        for (p, place) in moved.places.iter_mut().enumerate() {
            *place = [0, 1, 2].map(|i| shape.places[p][i] + shares[p] * moves[p][i] as f32);
        }
        let turned = uprights.turned(&moved, matrices);
        if turned.is_empty() {
            return Some(moved);
        }
        for t in turned {
            for p in shape.corner_places(t) {
                shares[p] *= if round < 4 { 0.5 } else { 0.0 };
            }
        }
    }
    None
}

fn mean_edges(shape: &Shape) -> Vec<f32> {
    let (mut sums, mut counts) = (vec![0.0_f32; shape.places.len()], vec![0_u32; shape.places.len()]);
    for t in 0..shape.triangles.len() {
        let corners = shape.corner_places(t);
        for i in 0..3 {
            let along = sub(shape.places[corners[(i + 1) % 3]], shape.places[corners[i]]);
            let length = dot(along, along).sqrt();
            for p in [corners[i], corners[(i + 1) % 3]] {
                sums[p] += length;
                counts[p] += 1;
            }
        }
    }
    sums.iter().zip(&counts).map(|(sum, &count)| sum / count.max(1) as f32).collect()
}
