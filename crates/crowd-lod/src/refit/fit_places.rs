//! Moves the places of a level by least squares over its pairs: linear, as the skinning stays as it is.

use super::pairs::{Contact, Pair};
use super::shape::Shape;
use crate::Mat3x4;
use crate::quadrics::{cross, dot, sub};
use rayon::prelude::*;

/// Share of the pull that also holds along the surface, where the distance alone says nothing.
const SLIDE_SHARE: f64 = 0.05;
/// Pull back to where a place is, relative to the mean pull on its neighbours.
const DAMPING: f64 = 1.0e-3;
/// Steps of the conjugate gradients at most.
const SOLVER_STEPS: usize = 60;
/// Share of the first residual at which the solver stops.
const SOLVER_RESIDUAL: f64 = 1.0e-3;
/// A place moves at most this share of its mean edge length in one round.
const STEP_LIMIT: f32 = 0.5;
/// A triangle may turn, in any frame, up to this cosine from where it was before the fit.
const TURN_COS: f32 = 0.2;

/// The normal equations of a triangle: 3 x 3 blocks of 3 x 3, and the right side.
#[derive(Clone)]
struct Local {
    matrix: [[f64; 9]; 9],
    right: [f64; 9],
}

/// Where each place should go, metres, from where it is.
pub(crate) fn solve_places(shape: &Shape, matrices: &[Vec<Mat3x4>], pairs: &[Pair]) -> Vec<[f64; 3]> {
    let by_triangle = sort_by_triangle(shape.triangles.len(), pairs);
    let mut locals: Vec<Local> = by_triangle
        .par_iter()
        .enumerate()
        .map(|(t, pairs)| local_equations(shape.triangles[t], matrices, pairs))
        .collect();
    let corners: Vec<[usize; 3]> = (0..shape.triangles.len()).map(|t| shape.corner_places(t)).collect();
    add_damping(&mut locals);
    conjugate_gradients(&locals, &corners, shape.places.len())
}

/// Pairs of each triangle, in the order given.
pub(crate) fn sort_by_triangle(triangle_count: usize, pairs: &[Pair]) -> Vec<Vec<&Pair>> {
    let mut sorted = vec![Vec::new(); triangle_count];
    for pair in pairs {
        sorted[pair.triangle as usize].push(pair);
    }
    sorted
}

/// How much an offset counts, by direction.
pub(crate) fn stiffness(contact: Contact) -> [[f64; 3]; 3] {
    let along = |v: [f32; 3], on: f64, off: f64| {
        let v = v.map(f64::from);
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| (on - off) * v[i] * v[j] + if i == j { off } else { 0.0 }))
    };
    match contact {
        Contact::Face(normal) => along(normal, 1.0, SLIDE_SHARE),
        Contact::Edge(direction) => along(direction, SLIDE_SHARE, 1.0),
        Contact::Corner => along([0.0; 3], 1.0, 1.0),
    }
}

fn local_equations(corners: [u32; 3], matrices: &[Vec<Mat3x4>], pairs: &[&Pair]) -> Local {
    let mut local = Local { matrix: [[0.0; 9]; 9], right: [0.0; 9] };
    for pair in pairs {
        let stiff = stiffness(pair.contact);
        let share = f64::from(pair.share);
        let offset = pair.offset.map(f64::from);
        // Derivative of the point by each corner's place, and the same times the stiffness.
        let slopes = [0, 1, 2].map(|k| {
            let m = &matrices[pair.frame as usize][corners[k] as usize];
            let weight = f64::from(pair.weights[k]);
            [0, 1, 2].map(|row| [0, 1, 2].map(|column| weight * f64::from(m[row][column])))
        });
        let pulled = slopes.map(|s| multiply(&stiff, &s));
        for k in 0..3 {
            for i in 0..3 {
                let pull: f64 = (0..3).map(|row| pulled[k][row][i] * offset[row]).sum();
                local.right[k * 3 + i] -= share * pull;
                for l in 0..3 {
                    for j in 0..3 {
                        let product: f64 = (0..3).map(|row| slopes[k][row][i] * pulled[l][row][j]).sum();
                        local.matrix[k * 3 + i][l * 3 + j] += share * product;
                    }
                }
            }
        }
    }
    local
}

fn multiply(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Holds every corner a little where it is, so that places without pairs stay and thin ones do not run.
fn add_damping(locals: &mut [Local]) {
    let trace: f64 = locals.iter().map(|l| (0..9).map(|i| l.matrix[i][i]).sum::<f64>()).sum();
    let mean = trace / (9 * locals.len().max(1)) as f64;
    for local in locals {
        for i in 0..9 {
            local.matrix[i][i] += DAMPING * mean;
        }
    }
}

fn conjugate_gradients(locals: &[Local], corners: &[[usize; 3]], place_count: usize) -> Vec<[f64; 3]> {
    let mut residual = vec![[0.0_f64; 3]; place_count];
    let mut blocks = vec![[[0.0_f64; 3]; 3]; place_count];
    for (local, corners) in locals.iter().zip(corners) {
        for k in 0..3 {
            for i in 0..3 {
                residual[corners[k]][i] += local.right[k * 3 + i];
                for j in 0..3 {
                    blocks[corners[k]][i][j] += local.matrix[k * 3 + i][k * 3 + j];
                }
            }
        }
    }
    let inverses: Vec<[[f64; 3]; 3]> = blocks.iter().map(invert).collect();
    let precondition = |r: &[[f64; 3]]| -> Vec<[f64; 3]> {
        r.iter().zip(&inverses).map(|(r, m)| m.map(|row| row[0] * r[0] + row[1] * r[1] + row[2] * r[2])).collect()
    };
    let mut solution = vec![[0.0_f64; 3]; place_count];
    let mut direction = precondition(&residual);
    let mut energy = inner(&residual, &direction);
    let goal = energy * SOLVER_RESIDUAL * SOLVER_RESIDUAL;
    for _ in 0..SOLVER_STEPS {
        if energy <= goal || energy.is_nan() {
            break;
        }
        let image = apply(locals, corners, &direction);
        let curvature = inner(&direction, &image);
        if curvature <= 0.0 || curvature.is_nan() {
            break;
        }
        let step = energy / curvature;
        for p in 0..place_count {
            for i in 0..3 {
                solution[p][i] += step * direction[p][i];
                residual[p][i] -= step * image[p][i];
            }
        }
        let preconditioned = precondition(&residual);
        let next = inner(&residual, &preconditioned);
        let keep = next / energy;
        energy = next;
        for p in 0..place_count {
            for i in 0..3 {
                direction[p][i] = preconditioned[p][i] + keep * direction[p][i];
            }
        }
    }
    solution
}

fn inner(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
}

fn apply(locals: &[Local], corners: &[[usize; 3]], x: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut out = vec![[0.0_f64; 3]; x.len()];
    for (local, corners) in locals.iter().zip(corners) {
        let mut at = [0.0; 9];
        for k in 0..3 {
            at[k * 3..k * 3 + 3].copy_from_slice(&x[corners[k]]);
        }
        for k in 0..3 {
            for i in 0..3 {
                let row = &local.matrix[k * 3 + i];
                out[corners[k]][i] += (0..9).map(|j| row[j] * at[j]).sum::<f64>();
            }
        }
    }
    out
}

/// The inverse of a symmetric positive matrix; zero where there is none, so that its place stays.
fn invert(m: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let minor = |a: usize, b: usize, c: usize, d: usize| m[a][c] * m[b][d] - m[a][d] * m[b][c];
    let first = [minor(1, 2, 1, 2), -minor(1, 2, 0, 2), minor(1, 2, 0, 1)];
    let determinant = m[0][0] * first[0] + m[0][1] * first[1] + m[0][2] * first[2];
    if !determinant.is_normal() {
        return [[0.0; 3]; 3];
    }
    let second = [-minor(0, 2, 1, 2), minor(0, 2, 0, 2), -minor(0, 2, 0, 1)];
    let third = [minor(0, 1, 1, 2), -minor(0, 1, 0, 2), minor(0, 1, 0, 1)];
    [0, 1, 2].map(|i| [first[i] / determinant, second[i] / determinant, third[i] / determinant])
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

    /// Triangles that have turned over in some frame.
    fn turned(&self, shape: &Shape, matrices: &[Vec<Mat3x4>]) -> Vec<usize> {
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
