//! Takes one level of an order out as a mesh of its own.

use crate::{CollapseOrder, Level, LodMesh, reform};

/// One level as a mesh of its own.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LevelMesh {
    /// Vertices of the order that the level's triangles use, rising. One refitted may come several times, at places of its own: it says
    /// which material and colour a vertex has.
    pub vertices: Vec<u32>,
    /// Vertex of the order that each of `vertices` stands at: itself, but where a refit gave a triangle other colours.
    pub stands_at: Vec<u32>,
    /// Corners as indices into `vertices`, one entry per triangle of the level, in the order's sequence.
    pub triangles: Vec<[u32; 3]>,
    /// Bind-space position of each of `vertices`, metres.
    pub positions: Vec<[f32; 3]>,
    /// Unit normal of each of `vertices`.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinate of each of `vertices`.
    pub uvs: Vec<[f32; 2]>,
    /// Joint indices of each of `vertices`.
    pub joints: Vec<[u16; 4]>,
    /// Weights of each of `vertices`, as the mesh had them: summing to 1.
    pub weights: Vec<[f32; 4]>,
}

/// The level with the places and attributes that its vertices have in `mesh`.
///
/// Place and skinning come from [`CollapseOrder::vertex_source`], texture coordinate from
/// [`CollapseOrder::attribute_source`], normal from [`CollapseOrder::normal_source`]. `mesh` is the one that `order` was
/// made from, `level` one of its levels.
///
/// Panics if an index of the order lies outside `mesh`.
pub fn level_mesh(mesh: &LodMesh<'_>, order: &CollapseOrder, level: &Level) -> LevelMesh {
    let mut triangles = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
    let mut vertices: Vec<u32> = triangles.as_flattened().to_vec();
    vertices.sort_unstable();
    vertices.dedup();
    let mut place = vec![0_u32; order.vertex_source.len()];
    for (i, &v) in vertices.iter().enumerate() {
        place[v as usize] = i as u32;
    }
    for corner in triangles.as_flattened_mut() {
        *corner = place[*corner as usize];
    }
    let source = |v: &u32| order.vertex_source[*v as usize] as usize;
    let attributes = |v: &u32| order.attribute_source[*v as usize] as usize;
    let normal = |v: &u32| order.normal_source[*v as usize] as usize;
    LevelMesh {
        positions: vertices.iter().map(|v| mesh.positions[source(v)]).collect(),
        normals: vertices.iter().map(|v| mesh.normals[normal(v)]).collect(),
        uvs: vertices.iter().map(|v| mesh.uvs[attributes(v)]).collect(),
        joints: vertices.iter().map(|v| mesh.joints[source(v)]).collect(),
        weights: vertices.iter().map(|v| mesh.weights[source(v)]).collect(),
        stands_at: vertices.clone(),
        vertices,
        triangles,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{TestPoses, quick, simplify_checked, uv_sphere};

    #[test]
    fn a_level_holds_what_its_triangles_use() {
        let mesh = uv_sphere(16, 12);
        let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
        for level in &order.levels {
            let taken = level_mesh(&mesh.mesh(), &order, level);
            let reformed = reform(&order.triangles, &order.collapse_map, level.vertex_count, level.triangle_count);
            assert_eq!(taken.triangles.len(), level.triangle_count as usize);
            assert!(taken.vertices.is_sorted_by(|a, b| a < b));
            for (corners, ordered) in taken.triangles.iter().zip(&reformed) {
                assert_eq!(corners.map(|c| taken.vertices[c as usize]), *ordered);
            }
            for (i, &v) in taken.vertices.iter().enumerate() {
                let (place, attributes) = (order.vertex_source[v as usize], order.attribute_source[v as usize]);
                assert_eq!(taken.positions[i], mesh.positions[place as usize]);
                assert_eq!(taken.uvs[i], mesh.uvs[attributes as usize]);
            }
        }
    }

    #[test]
    fn nothing_gives_nothing() {
        let mesh = uv_sphere(4, 3);
        assert_eq!(level_mesh(&mesh.mesh(), &CollapseOrder::default(), &Level::default()), LevelMesh::default());
    }
}
