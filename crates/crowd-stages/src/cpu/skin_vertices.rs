//! All vertices of the drawn instances, each skinned once.

use super::pose_instance::skin_matrix;
use crate::{BucketPlace, BucketRange, Buckets, CrowdData, DrawnInstance, OriginRecord, SkinnedVertex};
use crowd_pack::{NONE, VertexRecord, decode_normal};
use glam::{Vec3, Vec4};

/// The vertices of every drawn instance at its level, in its character's own space, moved between levels where they morph; in the
/// places of `place_buckets`, as many as were placed.
///
/// `origins`: of [`crate::Buckets::origins`]; `ranges`: of `write_bucket_args`; `drawn`: of `gather_drawn`; `palettes`: of
/// `blend_palettes`.
///
/// Paper: Peng 2011 Eq. 2 (§5.3), computed in the vertex shader there. Departs: once, however many passes draw the vertex.
/// Twin: `shaders/stages/skin_vertices.wgsl`. Within [`SKIN_BOUND`].
pub fn skin_vertices(
    data: &CrowdData,
    buckets: &Buckets,
    origins: &[OriginRecord],
    ranges: &[BucketRange],
    places: &[BucketPlace],
    drawn: &[DrawnInstance],
    palettes: &[[f32; 4]],
) -> Vec<SkinnedVertex> {
    let mut skinned = Vec::new();
    let meshes = ranges.iter().zip(places).take(buckets.mesh_count as usize);
    for (range, place) in meshes.filter(|(_, place)| place.vertex_base != NONE) {
        let mesh = place.vertex_offset as usize..(place.vertex_offset + place.vertex_count) as usize;
        for one in &drawn[range.first as usize..range.end as usize] {
            let rows = &palettes[one.palette_row as usize..][..one.row_count as usize];
            let palette: Vec<Vec4> = rows.iter().copied().map(Vec4::from_array).collect();
            let pairs = data.vertices[mesh.clone()].iter().zip(&origins[mesh.clone()]);
            skinned.extend(pairs.map(|(vertex, origin)| skin(&palette, vertex, origin, one)));
        }
    }
    skinned
}

fn skin(palette: &[Vec4], vertex: &VertexRecord, origin: &OriginRecord, one: &DrawnInstance) -> SkinnedVertex {
    let share = if origin.vertex >= one.coarser_vertex_count { one.fraction } else { 1.0 };
    let own = skin_matrix(palette, vertex.joints, vertex.weights);
    let other = skin_matrix(palette, origin.joints, origin.weights);
    let rows = [0, 1, 2].map(|r| other[r].lerp(own[r], share));
    let position = Vec3::from_array(origin.position).lerp(Vec3::from_array(vertex.position), share).extend(1.0);
    let normals = [origin.normal_oct, vertex.normal_oct].map(|packed| Vec3::from_array(decode_normal(packed)));
    let normal = normals[0].lerp(normals[1], share).extend(0.0);
    let [x, y, z] = rows.map(|row| row.dot(position));
    let [normal_x, normal_y, normal_z] = rows.map(|row| row.dot(normal));
    SkinnedVertex { x, y, z, normal_x, normal_y, normal_z }
}

/// How far GPU and CPU may differ, metres and parts of a normal of length 1: matrices of a few metres are added up in another order.
pub const SKIN_BOUND: f32 = 2e-5;
