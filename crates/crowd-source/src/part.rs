//! One part of a character on its way into the common mesh: repair normals, weld equal vertices, append.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

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

/// Merges vertices that agree in every attribute, and drops those that no triangle uses; the first of each group stays,
/// in the order in which triangles meet them.
pub(crate) fn weld_vertices(part: &mut PartMesh) {
    let mut welded = PartMesh::default();
    let mut known: HashMap<Vec<u32>, u32> = HashMap::with_capacity(part.positions.len());
    let mut vertex_remap = vec![u32::MAX; part.positions.len()];
    let mut triangles = std::mem::take(&mut part.triangles);
    for triangle in &mut triangles {
        for corner in triangle {
            let v = *corner as usize;
            if vertex_remap[v] == u32::MAX {
                let fresh = welded.positions.len() as u32;
                let key = [
                    float_bits(part.positions[v]).as_slice(),
                    &float_bits(part.normals[v]),
                    &float_bits(part.uvs[v]),
                    &[u32::from_le_bytes(part.colors[v])],
                    &part.joints[v].map(u32::from),
                    &float_bits(part.weights[v]),
                ]
                .concat();
                vertex_remap[v] = *known.entry(key).or_insert(fresh);
                if vertex_remap[v] == fresh {
                    welded.positions.push(part.positions[v]);
                    welded.normals.push(part.normals[v]);
                    welded.uvs.push(part.uvs[v]);
                    welded.colors.push(part.colors[v]);
                    welded.joints.push(part.joints[v]);
                    welded.weights.push(part.weights[v]);
                }
            }
            *corner = vertex_remap[v];
        }
    }
    welded.triangles = triangles;
    *part = welded;
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
