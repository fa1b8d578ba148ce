//! The whole of [`crate::simplify`] on small meshes, and on any mesh.

use crate::test_meshes::*;
use crate::{Criteria, LodOptions, VertexClass, simplify};

#[test]
fn uv_sphere_reaches_a_handful_of_triangles_and_stays_closed() {
    let mesh = uv_sphere(24, 16);
    let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
    assert!(order.levels[0].triangle_count < 60, "{:?} {:?}", order.levels[0], order.blocked);
}

#[test]
fn cube_with_charts_reaches_its_twelve_triangles() {
    let order = simplify_checked(&cube(6), &TestPoses::rest(), &quick());
    assert_eq!(order.levels[0].triangle_count, 12, "{:?}", order.blocked);
    assert_eq!(order.levels[0].vertex_count, 24);
    assert_eq!(order.levels[0].error_m, 0.0);
}

#[test]
fn tube_and_grid_keep_their_borders() {
    let order = simplify_checked(&tube(16, 20, 6.0, false), &TestPoses::rest(), &quick());
    assert!(order.levels[0].triangle_count < 40, "{:?} {:?}", order.levels[0], order.blocked);
    let flat = grid(12, 9, |_, _| 0.0, |_, _| false);
    let order = simplify_checked(&flat, &TestPoses::rest(), &quick());
    assert!(order.levels[0].triangle_count <= 2, "{:?} {:?}", order.levels[0], order.blocked);
}
