//! Splits a level into glTF primitives: one per material, each with only the vertices it uses.

/// Triangles of one material over their own vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Primitive {
    /// Material, local to the character.
    pub(crate) material: u32,
    /// For each vertex of the primitive, its index in the character; rising.
    pub(crate) vertices: Vec<u32>,
    /// Three a triangle, into `vertices`.
    pub(crate) indices: Vec<u32>,
}

/// One primitive per material that has triangles, by rising material.
///
/// `vertex_materials[v]`: material of a vertex; a triangle has that of its first corner.
pub(crate) fn gather_primitives(level_triangles: &[[u32; 3]], vertex_materials: &[u32]) -> Vec<Primitive> {
    let material_of = |triangle: &[u32; 3]| vertex_materials[triangle[0] as usize];
    let mut materials: Vec<u32> = level_triangles.iter().map(material_of).collect();
    materials.sort_unstable();
    materials.dedup();
    let gather = |material: u32| {
        let triangles = || level_triangles.iter().filter(move |triangle| material_of(triangle) == material);
        let mut vertices: Vec<u32> = triangles().flatten().copied().collect();
        vertices.sort_unstable();
        vertices.dedup();
        let place = |vertex: &u32| vertices.binary_search(vertex).expect("every corner was listed") as u32;
        let indices = triangles().flatten().map(place).collect();
        Primitive { material, vertices, indices }
    };
    materials.into_iter().map(gather).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_material_gets_its_own_vertices() {
        let primitives = gather_primitives(&[[0, 1, 2], [5, 4, 3], [2, 1, 6]], &[0, 0, 0, 2, 2, 2, 0]);
        assert_eq!(primitives.len(), 2);
        assert_eq!(primitives[0].vertices, [0, 1, 2, 6]);
        assert_eq!(primitives[0].indices, [0, 1, 2, 2, 1, 3]);
        assert_eq!(primitives[1], Primitive { material: 2, vertices: vec![3, 4, 5], indices: vec![2, 1, 0] });
    }
}
