//! Takes root motion out of a posed cloud of points: the turn and shift that lay it best on the cloud at rest.

/// Rotations after which the 4 x 4 matrix counts as diagonal: six pairs, each visited often enough.
const SWEEPS: usize = 8;

/// Turns and shifts `posed` as a whole so that its points lie closest to those at rest, in the sum of squares.
///
/// `rest` and `posed`: the same points, metres. Without a point nothing happens.
///
/// Paper: Horn 1987, "Closed-form solution of absolute orientation using unit quaternions", section 4.
pub(crate) fn align_to_rest(rest: &[[f32; 3]], posed: &mut [[f32; 3]]) {
    if posed.is_empty() {
        return;
    }
    let (rest_mean, posed_mean) = (mean(rest), mean(posed));
    // Sums of products of coordinates: posed times rest.
    let mut s = [[0.0_f64; 3]; 3];
    for (p, r) in posed.iter().zip(rest) {
        for i in 0..3 {
            for j in 0..3 {
                s[i][j] += (f64::from(p[i]) - posed_mean[i]) * (f64::from(r[j]) - rest_mean[j]);
            }
        }
    }
    let turn = best_turn(&s);
    for p in posed {
        let d = [0, 1, 2].map(|i| f64::from(p[i]) - posed_mean[i]);
        *p = [0, 1, 2].map(|i| {
            let turned = turn[i][0] * d[0] + turn[i][1] * d[1] + turn[i][2] * d[2];
            (turned + rest_mean[i]) as f32
        });
    }
}

fn mean(points: &[[f32; 3]]) -> [f64; 3] {
    let mut sum = [0.0_f64; 3];
    for p in points {
        (0..3).for_each(|i| sum[i] += f64::from(p[i]));
    }
    sum.map(|c| c / points.len() as f64)
}

/// The rotation that maximises the trace of its product with `s`.
fn best_turn(s: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = *s;
    let matrix = [
        [xx + yy + zz, yz - zy, zx - xz, xy - yx],
        [yz - zy, xx - yy - zz, xy + yx, zx + xz],
        [zx - xz, xy + yx, yy - xx - zz, yz + zy],
        [xy - yx, zx + xz, yz + zy, zz - xx - yy],
    ];
    let [w, x, y, z] = largest_eigenvector(matrix);
    [
        [w * w + x * x - y * y - z * z, 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), w * w - x * x + y * y - z * z, 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w * w - x * x - y * y + z * z],
    ]
}

/// Unit eigenvector of the largest eigenvalue of a symmetric matrix, by Jacobi rotations.
fn largest_eigenvector(mut a: [[f64; 4]; 4]) -> [f64; 4] {
    let mut vectors = [[0.0; 4]; 4];
    (0..4).for_each(|i| vectors[i][i] = 1.0);
    for _ in 0..SWEEPS {
        for (p, q) in [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = if theta >= 0.0 { 1.0 } else { -1.0 } / (theta.abs() + (theta * theta + 1.0).sqrt());
            let c = 1.0 / (t * t + 1.0).sqrt();
            let s = t * c;
            for k in 0..4 {
                let (kp, kq) = (a[k][p], a[k][q]);
                (a[k][p], a[k][q]) = (c * kp - s * kq, s * kp + c * kq);
            }
            for k in 0..4 {
                let (pk, qk) = (a[p][k], a[q][k]);
                (a[p][k], a[q][k]) = (c * pk - s * qk, s * pk + c * qk);
            }
            for row in &mut vectors {
                let (p_part, q_part) = (row[p], row[q]);
                (row[p], row[q]) = (c * p_part - s * q_part, s * p_part + c * q_part);
            }
        }
    }
    let largest = (0..4).max_by(|&i, &j| a[i][i].total_cmp(&a[j][j]).then(j.cmp(&i))).expect("four values");
    [0, 1, 2, 3].map(|i| vectors[i][largest])
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// A cloud that was only turned and shifted comes back to where it was.
        #[test]
        fn root_motion_leaves_no_trace(
            points in prop::collection::vec([-1.0_f32..1.0, -1.0_f32..1.0, -1.0_f32..1.0], 4..40),
            turn_rad in [-3.1_f32..3.1, -1.5_f32..1.5],
            shift in [-9.0_f32..9.0, -9.0_f32..9.0, -9.0_f32..9.0],
        ) {
            let [(s, c), (t, d)] = turn_rad.map(|angle| (libm::sinf(angle), libm::cosf(angle)));
            let about_y = |p: [f32; 3]| [c * p[0] + s * p[2], p[1], c * p[2] - s * p[0]];
            let about_x = |p: [f32; 3]| [p[0], d * p[1] - t * p[2], t * p[1] + d * p[2]];
            let mut posed: Vec<[f32; 3]> =
                points.iter().map(|&p| about_x(about_y(p))).map(|p| [0, 1, 2].map(|i| p[i] + shift[i])).collect();
            align_to_rest(&points, &mut posed);
            for (a, b) in points.iter().zip(&posed) {
                for i in 0..3 {
                    prop_assert!((a[i] - b[i]).abs() < 1.0e-4, "{a:?} {b:?}");
                }
            }
        }
    }

    #[test]
    fn no_point_and_one_point_are_no_trouble() {
        align_to_rest(&[], &mut []);
        let mut one = [[5.0, 6.0, 7.0]];
        align_to_rest(&[[1.0, 2.0, 3.0]], &mut one);
        assert_eq!(one, [[1.0, 2.0, 3.0]]);
    }

    #[test]
    fn a_bend_stays() {
        let rest = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 2.0, 0.0], [1.0, 0.0, 0.0]];
        let mut bent = rest;
        bent[2] = [0.0, 1.0, 1.0];
        align_to_rest(&rest, &mut bent);
        let moved = (0..3).map(|i| (bent[2][i] - rest[2][i]).abs()).fold(0.0, f32::max);
        assert!(moved > 0.3, "{bent:?}");
    }
}
