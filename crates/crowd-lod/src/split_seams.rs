//! Splits a mesh into positions, wedges and normal variants (Peng 2011 §4.1).
//!
//! A *position* is a place with its skinning: what moves as one in every pose (sheets of two materials that lie on each
//! other are kept apart, see `separate_layers`). A *wedge* is a position with one texture
//! coordinate, material and colour: the paper's universal index, and the members of its adjV groups. A *variant* is a wedge with
//! one normal: a vertex of the output. Variants follow their wedge and never hinder a collapse.

use crate::LodMesh;
use crate::duplicate_triangles::drop_duplicates;
use crate::lists::Lists;
use crate::separate_layers::separate_layers;
use rayon::prelude::*;

/// Normals closer than this become one variant: cos 1°.
const SAME_NORMAL_COS: f32 = 0.999_847_7;
/// Variants of one wedge that a normal is compared with; bounds the work on a hostile fan of normals.
const COMPARED_VARIANTS: usize = 32;

/// A mesh in three layers. Everything unreferenced or degenerate is gone.
#[derive(Debug, Clone, Default)]
pub(crate) struct SplitMesh {
    /// For each position, the lowest input vertex there.
    pub position_source: Vec<u32>,
    /// For each wedge, its position; ascending.
    pub wedge_position: Vec<u32>,
    /// For each wedge, an input vertex that has its coordinates.
    pub wedge_source: Vec<u32>,
    /// For each variant, its wedge; ascending.
    pub variant_wedge: Vec<u32>,
    /// For each variant, the input vertex whose texture coordinate and colour it carries.
    pub variant_source: Vec<u32>,
    /// For each variant, the input vertex whose normal it carries: the same one, but for stand-ins.
    pub variant_normal_source: Vec<u32>,
    /// For each variant, its texture coordinate.
    pub variant_uv: Vec<[f32; 2]>,
    /// For each variant, its colour.
    pub variant_color: Vec<[u8; 4]>,
    /// For each variant, its material.
    pub variant_material: Vec<u16>,
    /// Triangles in variants.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle, the input triangle.
    pub triangle_source: Vec<u32>,
    /// Input triangles left out because two corners share a position.
    pub degenerate_count: u32,
    /// Input triangles left out because another one says the same.
    pub duplicate_count: u32,
    /// Triangles that share all three positions with another one, and differ from it.
    pub coincident_count: u32,
    /// Variants at full detail; those after them are stand-ins.
    pub full_variant_count: u32,
}

impl SplitMesh {
    /// Position of a variant.
    pub fn position_of(&self, variant: u32) -> u32 {
        self.wedge_position[self.variant_wedge[variant as usize] as usize]
    }

    /// Place of each position in bind pose, metres.
    pub fn bind_places(&self, mesh: &LodMesh<'_>) -> Vec<[f32; 3]> {
        self.position_source.iter().map(|&v| mesh.positions[v as usize]).collect()
    }

    /// The input vertex whose place and skinning a variant has.
    pub fn place_source(&self, variant: u32) -> u32 {
        if variant < self.full_variant_count {
            self.variant_source[variant as usize]
        } else {
            self.position_source[self.position_of(variant) as usize]
        }
    }

    /// Adds a variant at `position` that shows the texture coordinate and colour of one variant and the normal of another. `wedge`: the
    /// wedge there that it joins, if it does.
    pub fn add_stand_in(&mut self, position: u32, wedge: Option<u32>, uv_of: u32, normal_of: u32) -> u32 {
        let (uv_of, normal_of) = (uv_of as usize, normal_of as usize);
        let wedge = wedge.unwrap_or_else(|| {
            self.wedge_position.push(position);
            self.wedge_source.push(self.variant_source[uv_of]);
            self.wedge_position.len() as u32 - 1
        });
        self.variant_wedge.push(wedge);
        self.variant_source.push(self.variant_source[uv_of]);
        self.variant_normal_source.push(self.variant_normal_source[normal_of]);
        self.variant_uv.push(self.variant_uv[uv_of]);
        self.variant_color.push(self.variant_color[uv_of]);
        self.variant_material.push(self.variant_material[uv_of]);
        self.variant_wedge.len() as u32 - 1
    }

    /// Wedges of each position, as offsets into the wedges: `offsets[p]..offsets[p + 1]`.
    pub fn wedge_offsets(&self) -> Vec<u32> {
        let mut offsets = vec![0_u32; self.position_source.len() + 1];
        for &p in &self.wedge_position {
            offsets[p as usize + 1] += 1;
        }
        for p in 0..self.position_source.len() {
            offsets[p + 1] += offsets[p];
        }
        offsets
    }
}

/// Splits `mesh` into positions, wedges and variants.
///
/// Ids ascend with the lowest input vertex of a position, then by texture coordinate, material, colour, then by input
/// vertex, so that they depend on the input alone. `mesh` must have been validated.
///
/// Paper: Peng 2011 §4.1. Departs: positions also need equal skinning, and normals split vertices without splitting
/// wedges.
pub(crate) fn split_seams(mesh: &LodMesh<'_>) -> SplitMesh {
    let mut leader = weld_positions(mesh, &[]);
    let mut split = SplitMesh::default();
    keep_proper_triangles(mesh, &leader, &mut split);
    if let Some(layers) = separate_layers(mesh, &leader, &split.triangle_source) {
        leader = weld_positions(mesh, &layers);
    }
    let position_of_vertex = number_positions(mesh, &leader, &mut split);
    split_wedges(mesh, &position_of_vertex, &mut split);
    drop_duplicates(&mut split);
    split.variant_normal_source = split.variant_source.clone();
    split.variant_uv = split.variant_source.iter().map(|&v| mesh.uvs[v as usize]).collect();
    split.variant_color = split.variant_source.iter().map(|&v| mesh.colors[v as usize]).collect();
    split.full_variant_count = split.variant_wedge.len() as u32;
    split
}

/// For each vertex, the lowest vertex with the same place, skinning and layer. `layers`: of each vertex, or none.
fn weld_positions(mesh: &LodMesh<'_>, layers: &[u16]) -> Vec<u32> {
    let keys: Vec<([u32; 3], [(u16, u16); 4], u16)> = (0..mesh.positions.len())
        .into_par_iter()
        .map(|v| {
            let skinning = skinning_key(mesh.joints[v], mesh.weights[v]);
            (mesh.positions[v].map(zero_signless_bits), skinning, layers.get(v).copied().unwrap_or(0))
        })
        .collect();
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.par_sort_unstable_by_key(|&v| (keys[v as usize], v));
    let mut leader = vec![0_u32; keys.len()];
    for group in order.chunk_by(|&a, &b| keys[a as usize] == keys[b as usize]) {
        for &v in group {
            leader[v as usize] = group[0];
        }
    }
    leader
}

/// Bits of a number with -0 taken for 0.
pub(crate) fn zero_signless_bits(x: f32) -> u32 {
    if x == 0.0 { 0 } else { x.to_bits() }
}

/// Influences in a form that is equal when they move a point alike: 1/65535 steps, by joint, zeros left out.
pub(crate) fn skinning_key(joints: [u16; 4], weights: [f32; 4]) -> [(u16, u16); 4] {
    let mut key = [(u16::MAX, 0_u16); 4];
    let mut used = 0;
    for i in 0..4 {
        let weight = (weights[i].clamp(0.0, 1.0) * 65535.0 + 0.5) as u16;
        if weight == 0 {
            continue;
        }
        match key[..used].iter().position(|&(joint, _)| joint == joints[i]) {
            Some(at) => key[at].1 = key[at].1.saturating_add(weight),
            None => {
                key[used] = (joints[i], weight);
                used += 1;
            }
        }
    }
    key[..used].sort_unstable();
    key
}

fn keep_proper_triangles(mesh: &LodMesh<'_>, leader: &[u32], split: &mut SplitMesh) {
    for (i, triangle) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| leader[v as usize]);
        if a == b || b == c || c == a {
            split.degenerate_count += 1;
        } else {
            split.triangle_source.push(i as u32);
        }
    }
}

/// Numbers the positions that triangles use, by their lowest vertex. Returns each vertex's position.
fn number_positions(mesh: &LodMesh<'_>, leader: &[u32], split: &mut SplitMesh) -> Vec<u32> {
    let mut used = vec![false; leader.len()];
    for &i in &split.triangle_source {
        for v in mesh.triangles[i as usize] {
            used[leader[v as usize] as usize] = true;
        }
    }
    let mut number = vec![u32::MAX; leader.len()];
    for v in 0..leader.len() {
        if used[v] {
            number[v] = split.position_source.len() as u32;
            split.position_source.push(v as u32);
        }
    }
    leader.iter().map(|&l| number[l as usize]).collect()
}

fn split_wedges(mesh: &LodMesh<'_>, position_of_vertex: &[u32], split: &mut SplitMesh) {
    let of_vertices = list_instances(mesh, &split.triangle_source);
    let instances = of_vertices.entries();
    let key = |i: u32| {
        let (v, material) = instances[i as usize];
        let v = v as usize;
        (position_of_vertex[v], mesh.uvs[v].map(zero_signless_bits), material, mesh.colors[v])
    };
    let mut order: Vec<u32> = (0..instances.len() as u32).collect();
    order.par_sort_unstable_by_key(|&i| (key(i), i));
    let mut variant_of_instance = vec![0_u32; instances.len()];
    for group in order.chunk_by(|&a, &b| key(a) == key(b)) {
        let wedge = split.wedge_position.len() as u32;
        let (first_vertex, material) = instances[group[0] as usize];
        split.wedge_position.push(position_of_vertex[first_vertex as usize]);
        split.wedge_source.push(first_vertex);
        let first_variant = split.variant_wedge.len();
        for &i in group {
            let vertex = instances[i as usize].0;
            let from = first_variant.max(split.variant_source.len().saturating_sub(COMPARED_VARIANTS));
            let same = split.variant_source[from..].iter().position(|&other| {
                cos_between(mesh.normals[vertex as usize], mesh.normals[other as usize]) >= SAME_NORMAL_COS
            });
            variant_of_instance[i as usize] = match same {
                Some(at) => (from + at) as u32,
                None => {
                    split.variant_wedge.push(wedge);
                    split.variant_source.push(vertex);
                    split.variant_material.push(material);
                    (split.variant_wedge.len() - 1) as u32
                }
            };
        }
    }

    split.triangles = split
        .triangle_source
        .par_iter()
        .map(|&i| {
            let material = mesh.triangle_materials[i as usize];
            mesh.triangles[i as usize].map(|v| {
                let of_vertex = of_vertices.range(v as usize);
                let at = instances[of_vertex.clone()].binary_search_by_key(&material, |instance| instance.1).ok();
                variant_of_instance[of_vertex.start + at.expect("every corner was put among the instances")]
            })
        })
        .collect();
}

/// Each input vertex with each material that it is seen with in some triangles, by vertex and sorted.
fn list_instances(mesh: &LodMesh<'_>, triangles: &[u32]) -> Lists<(u32, u16)> {
    let corners = |&i: &u32| mesh.triangles[i as usize].map(|v| (v, (v, mesh.triangle_materials[i as usize])));
    let mut instances = Lists::fill(mesh.positions.len(), triangles.iter().flat_map(corners));
    instances.sort_and_dedup_each();
    instances
}

/// Cosine between two normals; 1 when both are zero, as two missing normals agree.
pub(crate) fn cos_between(a: [f32; 3], b: [f32; 3]) -> f32 {
    let dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let lengths = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) * (b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
    if lengths > 0.0 {
        dot / lengths.sqrt()
    } else if a == b {
        1.0
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{TestMesh, uv_sphere};

    /// Two triangles over one edge, each with vertices of its own: 0 1 2 and 3 4 5, where 3 = 0 and 4 = 1.
    fn two_triangles() -> TestMesh {
        let mut mesh = TestMesh::default();
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (0.0, -1.0)] {
            mesh.vertex([x, y, 0.0], [x, y]);
        }
        mesh.triangle([0, 1, 2]);
        mesh.triangle([4, 3, 5]);
        mesh
    }

    fn counts(mesh: &TestMesh) -> [usize; 3] {
        let split = split_seams(&mesh.mesh());
        [split.position_source.len(), split.wedge_position.len(), split.variant_wedge.len()]
    }

    #[test]
    fn instances_are_those_of_a_plain_sort() {
        let mut mesh = uv_sphere(9, 7);
        for (t, material) in mesh.materials.iter_mut().enumerate() {
            *material = [7, 2, 2, 5][t % 4];
        }
        let kept: Vec<u32> = (0..mesh.triangles.len() as u32).filter(|t| t % 5 != 3).collect();
        let corners = |&t: &u32| mesh.triangles[t as usize].map(|v| (v, mesh.materials[t as usize]));
        let mut plain: Vec<(u32, u16)> = kept.iter().flat_map(corners).collect();
        plain.sort_unstable();
        plain.dedup();
        let instances = list_instances(&mesh.mesh(), &kept);
        assert_eq!(instances.entries(), plain);
        for v in 0..mesh.positions.len() {
            assert!(instances.at(v).iter().all(|instance| instance.0 == v as u32));
        }
    }

    #[test]
    fn equal_vertices_weld_to_one() {
        assert_eq!(counts(&two_triangles()), [4, 4, 4]);
    }

    #[test]
    fn zero_has_no_sign() {
        let mut mesh = two_triangles();
        mesh.positions[3] = [-0.0, -0.0, -0.0];
        mesh.uvs[4] = [1.0, -0.0];
        assert_eq!(counts(&mesh), [4, 4, 4]);
    }

    #[test]
    fn uv_colour_and_material_split_wedges_but_not_positions() {
        let mut mesh = two_triangles();
        mesh.uvs[3] = [0.5, 0.5];
        assert_eq!(counts(&mesh), [4, 5, 5]);
        mesh.colors[4] = [0, 0, 0, 255];
        assert_eq!(counts(&mesh), [4, 6, 6]);
        let mut mesh = two_triangles();
        mesh.materials[1] = 1;
        assert_eq!(counts(&mesh), [4, 6, 6]);
    }

    #[test]
    fn one_vertex_in_two_materials_is_two_wedges() {
        let mut mesh = two_triangles();
        mesh.triangles[1] = [1, 0, 5];
        mesh.materials[1] = 1;
        assert_eq!(counts(&mesh), [4, 6, 6]);
    }

    #[test]
    fn normals_split_variants_only_beyond_a_degree() {
        let mut mesh = two_triangles();
        mesh.normals[3] = [0.01, 0.0, 0.999_95];
        assert_eq!(counts(&mesh), [4, 4, 4]);
        mesh.normals[3] = [0.6, 0.0, 0.8];
        assert_eq!(counts(&mesh), [4, 4, 5]);
    }

    #[test]
    fn other_skinning_splits_the_position_but_other_order_does_not() {
        let mut mesh = two_triangles();
        mesh.joints[0] = [2, 5, 0, 0];
        mesh.weights[0] = [0.25, 0.75, 0.0, 0.0];
        mesh.joints[3] = [5, 9, 2, 0];
        mesh.weights[3] = [0.75, 0.0, 0.25, 0.0];
        assert_eq!(counts(&mesh), [4, 4, 4]);
        mesh.weights[3] = [0.7, 0.0, 0.3, 0.0];
        assert_eq!(counts(&mesh), [5, 5, 5]);
    }

    #[test]
    fn degenerate_triangles_and_unused_vertices_go() {
        let mut mesh = two_triangles();
        mesh.triangle([0, 3, 2]);
        mesh.vertex([9.0, 9.0, 9.0], [0.0, 0.0]);
        let split = split_seams(&mesh.mesh());
        assert_eq!((split.degenerate_count, split.triangles.len(), split.position_source.len()), (1, 2, 4));
    }
}
