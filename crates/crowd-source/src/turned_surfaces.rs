//! Finds surfaces whose triangles show their backs where their normals say front.

use crate::part::PartMesh;
use glam::{DVec3, Vec3};

/// What is said about such a surface.
pub(crate) const TURNED: &str = "triangles of surfaces that face away from their own normals are seen from behind only; \
     flip their faces or give them a double-sided material";

/// Share of a surface's area, turned minus not, above which the whole of it counts as turned.
const TURNED_SHARE: f64 = 0.5;

/// Counts the triangles of surfaces (triangles joined by vertices) of which most of the area faces away from the normals
/// that the file gives.
pub(crate) fn count_turned(part: &PartMesh) -> u64 {
    let mut toward_root: Vec<u32> = (0..part.positions.len() as u32).collect();
    for &[a, b, c] in &part.triangles {
        for (one, other) in [(a, b), (b, c)] {
            let (one, other) = (find_root(&mut toward_root, one), find_root(&mut toward_root, other));
            toward_root[one.max(other) as usize] = one.min(other);
        }
    }
    let vector = |list: &[[f32; 3]], v: u32| Vec3::from_array(list[v as usize]).as_dvec3();
    // By root: area times cosine, area, triangles.
    let mut sums = vec![(0.0_f64, 0.0_f64, 0_u64); part.positions.len()];
    for &[a, b, c] in &part.triangles {
        let at = |v| vector(&part.positions, v);
        let front = (at(b) - at(a)).cross(at(c) - at(a));
        let normals = vector(&part.normals, a) + vector(&part.normals, b) + vector(&part.normals, c);
        let sum = &mut sums[find_root(&mut toward_root, a) as usize];
        sum.0 += front.dot(normals.try_normalize().unwrap_or(DVec3::ZERO));
        sum.1 += front.length();
        sum.2 += 1;
    }
    sums.iter().filter(|sum| sum.0 < -TURNED_SHARE * sum.1).map(|sum| sum.2).sum()
}

fn find_root(toward_root: &mut [u32], mut member: u32) -> u32 {
    while toward_root[member as usize] != member {
        toward_root[member as usize] = toward_root[toward_root[member as usize] as usize];
        member = toward_root[member as usize];
    }
    member
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two squares apart from each other, both facing +z.
    fn two_squares() -> PartMesh {
        let square = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.]];
        let mut part = PartMesh::default();
        for x in [0.0, 5.0] {
            let first = part.positions.len() as u32;
            part.positions.extend(square.map(|p: [f32; 3]| [p[0] + x, p[1], p[2]]));
            part.normals.extend([[0., 0., 1.]; 4]);
            part.triangles.extend([[0, 1, 2], [1, 3, 2]].map(|t: [u32; 3]| t.map(|v| first + v)));
        }
        part
    }

    #[test]
    fn a_surface_is_turned_as_a_whole_or_not_at_all() {
        let mut part = two_squares();
        assert_eq!(count_turned(&part), 0);
        part.triangles[0].reverse();
        assert_eq!(count_turned(&part), 0, "half of a square");
        part.triangles[1].reverse();
        assert_eq!(count_turned(&part), 2, "one square");
        part.normals[..4].fill([0., 0., -1.]);
        assert_eq!(count_turned(&part), 0, "its normals turned with it");
    }

    #[test]
    fn nothing_and_no_area_are_not_turned() {
        assert_eq!(count_turned(&PartMesh::default()), 0);
        let mut part = two_squares();
        part.positions.fill([1.0; 3]);
        assert_eq!(count_turned(&part), 0);
    }
}
