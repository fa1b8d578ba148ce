//! Keeps apart sheets of different materials that lie on each other, such as two bodies for two outfits in one file.
//!
//! Welded, every edge of theirs would have four triangles and nothing could move. Apart, each is a surface of its own.

use crate::LodMesh;
use rayon::prelude::*;

/// Materials looked at where many lie on each other; bounds the work on a hostile pile.
const STACKED_MATERIALS: usize = 8;

/// For each vertex the layer it belongs to, or `None` when all is one layer.
///
/// Two materials get different layers when at least half of one's triangles have the same three places as triangles of the
/// other. `leader`: each vertex's place; `kept`: input triangles that count.
pub(crate) fn separate_layers(mesh: &LodMesh<'_>, leader: &[u32], kept: &[u32]) -> Option<Vec<u16>> {
    let mut triangle_counts = vec![0_u32; 1 << 16];
    let mut keys: Vec<([u32; 3], u16)> = Vec::with_capacity(kept.len());
    for &t in kept {
        let mut corners = mesh.triangles[t as usize].map(|v| leader[v as usize]);
        corners.sort_unstable();
        let material = mesh.triangle_materials[t as usize];
        triangle_counts[material as usize] += 1;
        keys.push((corners, material));
    }
    keys.par_sort_unstable();
    keys.dedup();

    // Pairs of materials, once for each pair of triangles on the same places.
    let mut pairs: Vec<(u16, u16)> = Vec::new();
    for stack in keys.chunk_by(|a, b| a.0 == b.0) {
        let stack = &stack[..stack.len().min(STACKED_MATERIALS)];
        for (i, upper) in stack.iter().enumerate() {
            pairs.extend(stack[..i].iter().map(|lower| (upper.1, lower.1)));
        }
    }
    pairs.sort_unstable();
    let mut layer_of_material = vec![0_u16; 1 << 16];
    let mut taken: Vec<u16> = Vec::new();
    for of_upper in pairs.chunk_by(|a, b| a.0 == b.0) {
        let upper = of_upper[0].0;
        taken.clear();
        for group in of_upper.chunk_by(|a, b| a == b) {
            let lower = group[0].1;
            let fewer = triangle_counts[upper as usize].min(triangle_counts[lower as usize]);
            if group.len() as u32 * 2 >= fewer {
                taken.push(layer_of_material[lower as usize]);
            }
        }
        // Lower materials have their layers by now: the pairs ascend.
        let free = (0..=taken.len() as u16).find(|layer| !taken.contains(layer));
        layer_of_material[upper as usize] = free.expect("one more layer than are taken");
    }
    if layer_of_material.iter().all(|&layer| layer == 0) {
        return None;
    }
    let mut layers = vec![0_u16; leader.len()];
    for &t in kept {
        let layer = layer_of_material[mesh.triangle_materials[t as usize] as usize];
        for v in mesh.triangles[t as usize] {
            layers[v as usize] = layers[v as usize].max(layer);
        }
    }
    Some(layers)
}

#[cfg(test)]
mod tests {
    use crate::test_meshes::{TestMesh, TestPoses, grid, quick, simplify_checked, uv_sphere};

    /// The same sphere in two materials, the second without its upper third.
    fn two_bodies() -> TestMesh {
        let mut mesh = uv_sphere(16, 12);
        let mut other = mesh.clone();
        let low = |t: &[u32; 3]| t.iter().all(|&v| other.positions[v as usize][2] < 0.5);
        other.triangles = mesh.triangles.iter().filter(|t| low(t)).copied().collect();
        other.materials = vec![1; other.triangles.len()];
        mesh.append(&other);
        mesh
    }

    #[test]
    fn bodies_on_each_other_simplify_apart() {
        let mesh = two_bodies();
        let order = crate::simplify(&mesh.mesh(), &TestPoses::rest().poses(), &quick(), &|_| ()).expect("a valid mesh");
        assert_eq!(order.seams.non_manifold_edge_count, 0);
        assert!(order.levels[0].triangle_count < 100, "{:?} {:?}", order.levels[0], order.blocked);
    }

    #[test]
    fn neighbouring_materials_stay_one_surface() {
        let mut mesh = grid(6, 6, |_, _| 0.0, |_, _| false);
        let count = mesh.materials.len();
        mesh.materials[count / 2..].fill(1);
        let order = simplify_checked(&mesh, &TestPoses::rest(), &quick());
        assert_eq!(order.seams.position_count, 49);
        assert_eq!(order.seams.border_count, 24 + 2);
    }
}
