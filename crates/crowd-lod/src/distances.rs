//! How far single points lie from a surface: what pictures of errors are painted with.

use crate::closest::ClosestTriangles;
use rayon::prelude::*;

/// Distance of each point to the nearest of some triangles, metres; infinite where there are none.
///
/// `points` and `positions`: in one space and pose, metres. `triangles`: indices into `positions`.
///
/// Panics if an index lies outside `positions`.
pub fn distances_to_surface(points: &[[f32; 3]], positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<f32> {
    let mut tree = ClosestTriangles::new(positions, triangles);
    tree.refit(positions, triangles);
    let closest = |&point: &[f32; 3]| tree.closest(point, positions, triangles, u32::MAX);
    points.par_iter().map(|point| closest(point).map_or(f32::INFINITY, |(_, squared)| squared.sqrt())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_point_has_its_own_distance() {
        let positions = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];
        let points = [[1.0, 1.0, 3.0], [-3.0, -4.0, 0.0], [2.0, 1.0, 0.0]];
        assert_eq!(distances_to_surface(&points, &positions, &[[0, 1, 2]]), [3.0, 5.0, 0.0]);
        assert_eq!(distances_to_surface(&points[..1], &positions, &[]), [f32::INFINITY]);
    }
}
