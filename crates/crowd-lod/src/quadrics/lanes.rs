//! One number, or one vector, for each of eight frames.

/// Frames in one block.
pub(super) const LANES: usize = 8;
/// One number for each frame of a block.
pub(super) type Lanes = [f32; LANES];

#[inline(always)]
pub(super) fn lanes_sub(a: &[Lanes; 3], b: &[Lanes; 3]) -> [Lanes; 3] {
    let mut d = [[0.0; LANES]; 3];
    for k in 0..3 {
        for i in 0..LANES {
            d[k][i] = a[k][i] - b[k][i];
        }
    }
    d
}

#[inline(always)]
pub(super) fn lanes_cross(a: &[Lanes; 3], b: &[Lanes; 3]) -> [Lanes; 3] {
    let mut c = [[0.0; LANES]; 3];
    for i in 0..LANES {
        c[0][i] = a[1][i] * b[2][i] - a[2][i] * b[1][i];
        c[1][i] = a[2][i] * b[0][i] - a[0][i] * b[2][i];
        c[2][i] = a[0][i] * b[1][i] - a[1][i] * b[0][i];
    }
    c
}

#[inline(always)]
pub(super) fn lanes_dot(a: &[Lanes; 3], b: &[Lanes; 3]) -> Lanes {
    let mut d = [0.0; LANES];
    for i in 0..LANES {
        d[i] = a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i];
    }
    d
}

/// Sum of products.
#[inline(always)]
pub(super) fn weighted_sum(values: &Lanes, weights: &Lanes) -> f32 {
    let mut products = [0.0; LANES];
    for i in 0..LANES {
        products[i] = values[i] * weights[i];
    }
    sum_lanes(&products)
}

/// Sum in one fixed order.
#[inline(always)]
pub(super) fn sum_lanes(s: &Lanes) -> f32 {
    ((s[0] + s[4]) + (s[2] + s[6])) + ((s[1] + s[5]) + (s[3] + s[7]))
}
