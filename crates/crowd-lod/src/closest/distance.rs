//! How far a point lies from triangles.

/// Three coordinates, one lane a triangle.
pub(crate) type Vectors<const N: usize> = [[f32; N]; 3];

/// Squared distance from a point to a triangle: to its plane when the point is above it, else to its edges.
#[inline]
pub(crate) fn triangle_distance_squared(point: [f32; 3], corners: [[f32; 3]; 3]) -> f32 {
    distances_squared(&[point], &[corners])[0]
}

/// Squared distance of each point to the triangle of its lane. All are computed alike, without branches, so that the lanes fill
/// vector operations; a lane has the same bits in any company.
#[inline(always)]
pub(crate) fn distances_squared<const N: usize>(points: &[[f32; 3]; N], triangles: &[[[f32; 3]; 3]; N]) -> [f32; N] {
    let mut corners = [[[0.0; N]; 3]; 3];
    let mut offsets = [[[0.0; N]; 3]; 3];
    for c in 0..3 {
        for k in 0..3 {
            for i in 0..N {
                corners[c][k][i] = triangles[i][c][k];
                offsets[c][k][i] = points[i][k] - triangles[i][c][k];
            }
        }
    }
    distances_by_offsets(&corners, &offsets)
}

/// The same for points and corners that lie in lanes already.
#[inline(always)]
pub(crate) fn distances_of_lanes<const N: usize>(points: &Vectors<N>, corners: &[Vectors<N>; 3]) -> [f32; N] {
    let offset = |c: usize| sub(points, &corners[c]);
    distances_by_offsets(corners, &[offset(0), offset(1), offset(2)])
}

/// `offsets`: from each corner to the point.
#[inline(always)]
fn distances_by_offsets<const N: usize>(corners: &[Vectors<N>; 3], offsets: &[Vectors<N>; 3]) -> [f32; N] {
    let [a, b, c] = *corners;
    let sides = [sub(&b, &a), sub(&c, &b), sub(&a, &c)];
    let n = cross(&sides[0], &sub(&c, &a));
    let length_squared = dot(&n, &n);
    // The closest point lies on an edge that the point is beyond.
    let mut least = [f32::INFINITY; N];
    for (side, offset) in sides.iter().zip(offsets) {
        let beyond = dot(&cross(&n, side), offset);
        let on_edge = segment_distances_squared(side, offset);
        least = lanes(|i| {
            let counts = (length_squared[i] <= f32::MIN_POSITIVE) | (beyond[i] < 0.0);
            if counts & (on_edge[i] < least[i]) { on_edge[i] } else { least[i] }
        });
    }
    let height = dot(&n, &offsets[0]);
    lanes(|i| if least[i] < f32::INFINITY { least[i] } else { height[i] * height[i] / length_squared[i] })
}

#[inline(always)]
fn segment_distances_squared<const N: usize>(along: &Vectors<N>, offset: &Vectors<N>) -> [f32; N] {
    let (length_squared, reached) = (dot(along, along), dot(offset, along));
    let share: [f32; N] = lanes(|i| {
        let share = reached[i] / length_squared[i];
        let share = if share > 0.0 { share } else { 0.0 };
        if share < 1.0 { share } else { 1.0 }
    });
    let part = |k: usize| lanes(|i| offset[k][i] - share[i] * along[k][i]);
    let rest = [part(0), part(1), part(2)];
    dot(&rest, &rest)
}

#[inline(always)]
pub(super) fn lanes<const N: usize>(lane: impl Fn(usize) -> f32) -> [f32; N] {
    let mut lanes = [0.0; N];
    for (i, value) in lanes.iter_mut().enumerate() {
        *value = lane(i);
    }
    lanes
}

#[inline(always)]
fn sub<const N: usize>(a: &Vectors<N>, b: &Vectors<N>) -> Vectors<N> {
    [lanes(|i| a[0][i] - b[0][i]), lanes(|i| a[1][i] - b[1][i]), lanes(|i| a[2][i] - b[2][i])]
}

#[inline(always)]
fn dot<const N: usize>(a: &Vectors<N>, b: &Vectors<N>) -> [f32; N] {
    lanes(|i| a[0][i] * b[0][i] + a[1][i] * b[1][i] + a[2][i] * b[2][i])
}

#[inline(always)]
fn cross<const N: usize>(a: &Vectors<N>, b: &Vectors<N>) -> Vectors<N> {
    let part = |j: usize, k: usize| lanes(|i| a[j][i] * b[k][i] - a[k][i] * b[j][i]);
    [part(1, 2), part(2, 0), part(0, 1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distance_to_a_triangle_by_hand() {
        let triangle = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        for (point, squared) in [
            ([1.0, 1.0, 3.0], 9.0),
            ([-3.0, -4.0, 0.0], 25.0),
            ([2.0, -2.0, 0.0], 4.0),
            ([4.0, 4.0, 0.0], 8.0),
            ([6.0, 0.0, 1.0], 5.0),
        ] {
            let found = triangle_distance_squared(point, triangle);
            assert!((found - squared).abs() < 1.0e-5, "{point:?}: {found}");
        }
        let thread = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
        assert_eq!(triangle_distance_squared([1.0, 2.0, 0.0], thread), 4.0);
    }

    #[test]
    fn a_lane_has_the_same_bits_in_any_company() {
        let number = |i: usize| libm::sinf(i as f32 * 12.9898) * 3.0;
        let place = |i: usize| [number(i), number(i + 1), number(i + 2)];
        let points: [[f32; 3]; 8] = std::array::from_fn(|i| place(i * 31));
        let triangles: [[[f32; 3]; 3]; 8] = std::array::from_fn(|i| [place(i), place(i * 7 + 100), place(i * (i % 3))]);
        let together = distances_squared(&points, &triangles);
        for i in 0..8 {
            assert_eq!(together[i].to_bits(), triangle_distance_squared(points[i], triangles[i]).to_bits());
        }
        let lanes_of = |places: [[f32; 3]; 8]| [0, 1, 2].map(|k| places.map(|place| place[k]));
        let corners = [0, 1, 2].map(|c| lanes_of(triangles.map(|triangle| triangle[c])));
        assert_eq!(distances_of_lanes(&lanes_of(points), &corners).map(f32::to_bits), together.map(f32::to_bits));
    }
}
