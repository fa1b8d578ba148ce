//! Drops triangles that say again what another one says, and counts those that lie on each other and differ.
//!
//! Left in, a triangle given twice would put four triangles on each of its edges: non-manifold, and nothing around it could
//! move.

use crate::split_seams::SplitMesh;
use rayon::prelude::*;

/// Keeps the first of triangles with the same three variants and the same front, and counts the others in
/// `duplicate_count`. Triangles that then still share all three places with another one (turned round, or with other
/// attributes) stay and are counted in `coincident_count`.
pub(crate) fn drop_duplicates(split: &mut SplitMesh) {
    let mut keys: Vec<([u32; 3], [u32; 3], u32)> = (0..split.triangles.len() as u32)
        .into_par_iter()
        .map(|t| {
            let corners = split.triangles[t as usize];
            let mut places = corners.map(|v| split.position_of(v));
            places.sort_unstable();
            (places, lowest_first(corners), t)
        })
        .collect();
    keys.par_sort_unstable();
    let mut dropped = vec![false; split.triangles.len()];
    for stack in keys.chunk_by(|a, b| a.0 == b.0) {
        let mut distinct = 0;
        for same in stack.chunk_by(|a, b| a.1 == b.1) {
            distinct += 1;
            same[1..].iter().for_each(|key| dropped[key.2 as usize] = true);
            split.duplicate_count += same.len() as u32 - 1;
        }
        split.coincident_count += if distinct > 1 { distinct } else { 0 };
    }
    if split.duplicate_count > 0 {
        let mut kept = dropped.iter().map(|dropped| !dropped);
        split.triangles.retain(|_| kept.next().expect("one entry per triangle"));
        let mut kept = dropped.iter().map(|dropped| !dropped);
        split.triangle_source.retain(|_| kept.next().expect("one entry per triangle"));
    }
}

/// The corners turned so that the lowest comes first: the same front, one spelling.
fn lowest_first([a, b, c]: [u32; 3]) -> [u32; 3] {
    if a <= b && a <= c {
        [a, b, c]
    } else if b <= c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

#[cfg(test)]
mod tests {
    use crate::split_seams::split_seams;
    use crate::test_meshes::{TestMesh, TestPoses, quick, simplify_checked, uv_sphere};

    fn counts(mesh: &TestMesh) -> (usize, u32, u32) {
        let split = split_seams(&mesh.mesh());
        assert_eq!(split.triangles.len(), split.triangle_source.len());
        (split.triangles.len(), split.duplicate_count, split.coincident_count)
    }

    fn two_triangles() -> TestMesh {
        let mut mesh = TestMesh::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            mesh.vertex([x, y, 0.0], [x, y]);
        }
        mesh.triangle([0, 1, 2]);
        mesh.triangle([1, 3, 2]);
        mesh
    }

    #[test]
    fn a_triangle_said_three_times_is_said_once() {
        let mut mesh = two_triangles();
        assert_eq!(counts(&mesh), (2, 0, 0));
        mesh.triangle([2, 0, 1]);
        mesh.triangle([0, 1, 2]);
        assert_eq!(counts(&mesh), (2, 2, 0));
        assert_eq!(split_seams(&mesh.mesh()).triangle_source, [0, 1], "the first one stays");
    }

    #[test]
    fn a_double_with_vertices_of_its_own_is_found_too() {
        let mut mesh = two_triangles();
        mesh.append(&two_triangles());
        assert_eq!(counts(&mesh), (2, 2, 0));
    }

    #[test]
    fn the_other_side_and_other_attributes_stay_and_are_counted() {
        let mut mesh = two_triangles();
        mesh.triangle([2, 1, 0]);
        assert_eq!(counts(&mesh), (3, 0, 2));
        let mut mesh = two_triangles();
        let mut other = two_triangles();
        other.uvs[0] = [0.5, 0.5];
        mesh.append(&other);
        assert_eq!(counts(&mesh), (3, 1, 2), "one triangle's texture differs, the other is a double");
    }

    #[test]
    fn a_sphere_said_twice_simplifies_like_one() {
        let mesh = uv_sphere(12, 8);
        let mut twice = mesh.clone();
        twice.append(&mesh);
        let order = simplify_checked(&twice, &TestPoses::rest(), &quick());
        assert_eq!(order.seams.duplicate_triangle_count as usize, mesh.triangles.len());
        assert_eq!(order.levels, simplify_checked(&mesh, &TestPoses::rest(), &quick()).levels);
    }
}
