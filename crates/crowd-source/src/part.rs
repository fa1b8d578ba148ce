//! One part of a character on its way into the common mesh: repair normals, weld equal vertices, append.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use crate::limits::{POSITION_M, UV};
use crate::{RawMesh, RawPart};

/// A part's own vertices and triangles, in the common bind space. Per-vertex arrays have one entry per vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PartMesh {
    pub(crate) positions: Vec<[f32; 3]>,
    pub(crate) normals: Vec<[f32; 3]>,
    pub(crate) uvs: Vec<[f32; 2]>,
    pub(crate) colors: Vec<[u8; 4]>,
    pub(crate) joints: Vec<[u16; 4]>,
    pub(crate) weights: Vec<[f32; 4]>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

/// What is said about triangles without area because two corners are one vertex.
pub(crate) const DEGENERATE: &str = "triangles that use one vertex twice were left out; nothing is seen of them";

/// What is said where none of the triangles is left.
pub(crate) fn all_degenerate(count: u64) -> String {
    format!("all {count} triangles are degenerate: two corners at one place; a character needs at least one triangle")
}

/// True when a position lies where no character does.
pub(crate) fn is_too_far(position: &[f32; 3]) -> bool {
    position.iter().any(|c| c.abs() > POSITION_M)
}

/// True for texture coordinates that show a place of a texture.
pub(crate) fn is_uv(uv: &[f32; 2]) -> bool {
    uv.iter().all(|c| c.abs() <= UV)
}

/// What is said about others.
pub(crate) const NO_UV: &str =
    "texture coordinates that are no numbers, or more than 1000000 textures off, became 0, 0";

/// What is said about such a position.
pub(crate) fn too_far(position: &[f32; 3]) -> String {
    format!(
        "lies at {position:?}, allowed up to {POSITION_M} m along each axis; files are in metres, scale the model down before export"
    )
}

/// Area-weighted unit normals, equal for vertices at one position. Lone and flat spots get +Y.
pub(crate) fn area_weighted_normals(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut first_at: HashMap<[u32; 3], u32> = HashMap::with_capacity(positions.len());
    let place: Vec<u32> = positions
        .iter()
        .enumerate()
        .map(|(v, p)| *first_at.entry(p.map(|c| (c + 0.0).to_bits())).or_insert(v as u32))
        .collect();
    let mut sums = vec![DVec3::ZERO; positions.len()];
    let at = |v: u32| Vec3::from_array(positions[v as usize]).as_dvec3();
    for &[a, b, c] in triangles {
        // The cross product's length is twice the area: the weight comes for free.
        let normal = (at(b) - at(a)).cross(at(c) - at(a));
        for corner in [a, b, c] {
            sums[place[corner as usize] as usize] += normal;
        }
    }
    place.iter().map(|&p| sums[p as usize].try_normalize().unwrap_or(DVec3::Y).as_vec3().to_array()).collect()
}

/// Gives every vertex a unit normal: area-weighted ones where there are none, or where one has no direction.
///
/// Returns how many normals had no direction.
pub(crate) fn complete_normals(part: &mut PartMesh) -> u64 {
    if part.normals.is_empty() {
        part.normals = area_weighted_normals(&part.positions, &part.triangles);
        return 0;
    }
    let mut repaired = 0;
    let mut computed: Option<Vec<[f32; 3]>> = None;
    for v in 0..part.normals.len() {
        let normal = Vec3::from_array(part.normals[v]).as_dvec3().try_normalize();
        part.normals[v] = match normal {
            Some(normal) => normal.as_vec3().to_array(),
            None => {
                repaired += 1;
                computed.get_or_insert_with(|| area_weighted_normals(&part.positions, &part.triangles))[v]
            }
        };
    }
    repaired
}

/// Merges vertices that agree in every attribute, leaves out triangles that then use a vertex twice, and drops vertices
/// that no triangle uses. The first of each group stays, in the order in which triangles meet them.
///
/// Returns how many triangles were left out.
pub(crate) fn weld_vertices(part: &mut PartMesh) -> u64 {
    let twin = first_twins(part);
    let found = part.triangles.len();
    let mut triangles: Vec<[u32; 3]> = part.triangles.iter().map(|t| t.map(|v| twin[v as usize])).collect();
    triangles.retain(|[a, b, c]| a != b && b != c && a != c);

    let mut welded = PartMesh::default();
    let mut vertex_remap = vec![u32::MAX; part.positions.len()];
    for corner in triangles.iter_mut().flatten() {
        let v = *corner as usize;
        if vertex_remap[v] == u32::MAX {
            vertex_remap[v] = welded.positions.len() as u32;
            welded.positions.push(part.positions[v]);
            welded.normals.push(part.normals[v]);
            welded.uvs.push(part.uvs[v]);
            welded.colors.push(part.colors[v]);
            welded.joints.push(part.joints[v]);
            welded.weights.push(part.weights[v]);
        }
        *corner = vertex_remap[v];
    }
    welded.triangles = triangles;
    *part = welded;
    (found - part.triangles.len()) as u64
}

/// For each vertex, the first one with the same attributes.
fn first_twins(part: &PartMesh) -> Vec<u32> {
    let mut first: HashMap<[u32; 17], u32> = HashMap::with_capacity(part.positions.len());
    let key = |v: usize| {
        let mut key = [0; 17];
        key[..3].copy_from_slice(&float_bits(part.positions[v]));
        key[3..6].copy_from_slice(&float_bits(part.normals[v]));
        key[6..8].copy_from_slice(&float_bits(part.uvs[v]));
        key[8] = u32::from_le_bytes(part.colors[v]);
        key[9..13].copy_from_slice(&part.joints[v].map(u32::from));
        key[13..].copy_from_slice(&float_bits(part.weights[v]));
        key
    };
    (0..part.positions.len()).map(|v| *first.entry(key(v)).or_insert(v as u32)).collect()
}

/// Bit patterns, with one zero instead of two.
fn float_bits<const N: usize>(numbers: [f32; N]) -> [u32; N] {
    numbers.map(|n| (n + 0.0).to_bits())
}

/// Adds the part to the character's mesh as one run of triangles.
pub(crate) fn append_part(mesh: &mut RawMesh, part: PartMesh, name: String, material: u32, rigid: bool) {
    let first_vertex = mesh.positions.len() as u32;
    let first_triangle = mesh.triangles.len() as u32;
    mesh.parts.push(RawPart { name, material, first_triangle, triangle_count: part.triangles.len() as u32, rigid });
    mesh.positions.extend(part.positions);
    mesh.normals.extend(part.normals);
    mesh.uvs.extend(part.uvs);
    mesh.colors.extend(part.colors);
    mesh.joints.extend(part.joints);
    mesh.weights.extend(part.weights);
    mesh.triangles.extend(part.triangles.iter().map(|t| t.map(|v| first_vertex + v)));
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2---3
    /// | \ |   vertices 4 and 5 are 1 and 2 again
    /// 0---1
    fn square() -> PartMesh {
        let corners = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.], [1., 1., 0.], [1., -0.0, 0.], [0., 1., 0.]];
        PartMesh {
            positions: corners.to_vec(),
            uvs: vec![[0.5; 2]; 6],
            colors: vec![[255; 4]; 6],
            joints: vec![[0; 4]; 6],
            weights: vec![[1., 0., 0., 0.]; 6],
            triangles: vec![[0, 1, 2], [4, 3, 5]],
            ..PartMesh::default()
        }
    }

    #[test]
    fn computed_normals_are_equal_where_positions_are() {
        let mut part = square();
        // Fold the far corner up: the two triangles now differ, the shared edge takes the mean.
        part.positions[3][2] = 1.0;
        let normals = area_weighted_normals(&part.positions, &part.triangles);
        assert_eq!((normals[1], normals[2]), (normals[4], normals[5]));
        assert_ne!(normals[0], normals[1]);
        for n in normals {
            assert!((Vec3::from_array(n).length() - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn larger_triangles_weigh_more() {
        let positions = [[0., 0., 0.], [10., 0., 0.], [0., 10., 0.], [0., 0., 1.]];
        let normals = area_weighted_normals(&positions, &[[0, 1, 2], [0, 2, 3]]);
        assert!(normals[0][2] > 0.9, "{:?}", normals[0]);
    }

    #[test]
    fn a_vertex_without_area_gets_some_normal() {
        assert_eq!(area_weighted_normals(&[[1.0; 3]; 3], &[[0, 1, 2]]), [[0., 1., 0.]; 3]);
    }

    #[test]
    fn equal_vertices_become_one_and_others_stay() {
        let mut part = square();
        assert_eq!(complete_normals(&mut part), 0);
        assert_eq!(weld_vertices(&mut part), 0);
        assert_eq!(part.triangles, [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(part.positions.len(), 4);

        let mut seam = square();
        seam.uvs[4] = [0.25; 2];
        complete_normals(&mut seam);
        weld_vertices(&mut seam);
        assert_eq!(seam.positions.len(), 5, "another texture point is another vertex");
    }

    #[test]
    fn triangles_that_fall_together_go_and_take_their_vertices_along() {
        let mut part = square();
        part.triangles = vec![[2, 5, 3], [0, 1, 2]];
        complete_normals(&mut part);
        assert_eq!(weld_vertices(&mut part), 1);
        assert_eq!(part.positions.len(), 3);
        assert_eq!(part.triangles, [[0, 1, 2]]);
    }
}
