//! Solves the normal equations of all triangles together: conjugate gradients, triangle by triangle.

use super::equations::Local;

/// Steps of the conjugate gradients at most.
const SOLVER_STEPS: usize = 60;
/// Share of the first residual at which the solver stops.
const SOLVER_RESIDUAL: f64 = 1.0e-3;

/// The moves of all places. `corners`: places of each triangle's corners. A place that nothing pulls stays.
pub(crate) fn conjugate_gradients(locals: &[Local], corners: &[[usize; 3]], place_count: usize) -> Vec<[f64; 3]> {
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
