//! Patches: what shows alike, and so has no border within. A chart is one, and all triangles of one layer in one plain colour are.
//!
//! By layers, since lumps of a beard that vanished would else draw those that are left.

use super::full_detail::FullDetail;
use super::repaint::Look;
use crate::split_seams::zero_signless_bits;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// That of triangles repainted in what no patch of their layer shows.
const NO_PATCH: u32 = u32::MAX;

/// An edge where a patch ends.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RimEdge {
    pub patch: u32,
    /// Vertices of the mesh.
    pub ends: [u32; 2],
    /// Triangle of full detail.
    pub triangle: u32,
}

/// Patches of full detail's triangles, and of a level's.
pub(crate) struct Patches {
    /// Of each triangle of full detail.
    of_full: Vec<u32>,
    /// Of each triangle of the level: that of the same triangle of full detail, unless it was repainted.
    pub of_level: Vec<u32>,
    /// The patch of each plain look of each layer, counted as its first triangle comes: materials may have other numbers in a pack.
    of_look: BTreeMap<(u32, Look), u32>,
}

impl Patches {
    /// Those of full detail; the `level_count` triangles of a level, which are its first, have the same ones.
    pub fn new(full: &FullDetail<'_>, level_count: usize) -> Self {
        let mut of_full = full.charts.of_triangle.clone();
        let first = of_full.iter().max().map_or(0, |&most| most + 1);
        let mut of_look = BTreeMap::new();
        for (t, patch) in of_full.iter_mut().enumerate() {
            if let Some(look) = full.plain_look(t as u32) {
                let next = first + of_look.len() as u32;
                *patch = *of_look.entry((full.layers[t], look)).or_insert(next);
            }
        }
        Self { of_level: of_full[..level_count].to_vec(), of_full, of_look }
    }

    /// Whether there are several plain looks: whether a triangle of a level could get another one.
    pub fn can_repaint(&self) -> bool {
        let mut looks = self.of_look.keys().map(|(_, look)| look);
        looks.next().is_some_and(|first| looks.any(|look| look != first))
    }

    /// Gives triangles of the level other plain looks. Where nothing of the layer looks so, full detail has no rim that they could look for.
    pub fn repaint(&mut self, full: &FullDetail<'_>, repainted: &[(usize, Look)]) {
        for &(t, look) in repainted {
            self.of_level[t] = self.of_look.get(&(full.layers[t], look)).copied().unwrap_or(NO_PATCH);
        }
    }

    /// The edges of full detail where patches end, by patch. A chart that touches itself along a seam
    /// has no rim there, as it has none in a level.
    pub fn rim_edges(&self, full: &FullDetail<'_>) -> Vec<RimEdge> {
        let place = |v: u32| full.mesh.positions[v as usize].map(zero_signless_bits);
        let ends = |corner: u32| {
            let (corners, i) = (full.triangles[corner as usize / 3], corner as usize % 3);
            [corners[i], corners[(i + 1) % 3]]
        };
        let side = |corner: u32| {
            let [a, b] = ends(corner).map(place);
            (self.of_full[corner as usize / 3], a.min(b), a.max(b), corner)
        };
        // Of all triangles: tints part plain ones within a chart.
        let mut sides: Vec<_> = (0..3 * full.triangles.len() as u32).map(side).collect();
        sides.par_sort_unstable();
        let rims = sides.chunk_by(|a, b| (a.0, a.1, a.2) == (b.0, b.1, b.2)).filter(|group| group.len() == 1);
        let mut rims: Vec<(u32, u32)> = rims.map(|group| (group[0].0, group[0].3)).collect();
        rims.sort_unstable();
        rims.into_iter().map(|(patch, corner)| RimEdge { patch, ends: ends(corner), triangle: corner / 3 }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_meshes::{PlainGrays, TestMesh, TestPoses, grid, quick};
    use crate::{Appearance, LodMesh, simplify};

    /// Calls back with full detail of a mesh, in gray steps by material, or in colours that nobody knows.
    fn with_full(mesh: &TestMesh, known: bool, see: impl Fn(&FullDetail<'_>)) {
        let appearance = Appearance { textures: known.then_some(&PlainGrays), ..Appearance::default() };
        let lod_mesh = LodMesh { appearance, ..mesh.mesh() };
        let poses = TestPoses::rest();
        let order = simplify(&lod_mesh, &poses.poses(), &quick(), &|_| ()).expect("a valid mesh");
        see(&FullDetail::new(&lod_mesh, &poses.poses(), &order, 1));
    }

    #[test]
    fn a_seam_of_the_texture_within_one_plain_color_is_no_rim() {
        let mut mesh = grid(6, 2, |_, _| 0.0, |x, _| x == 2);
        let right = |t: &[u32; 3]| t.iter().all(|&v| mesh.positions[v as usize][0] >= 4.0);
        mesh.materials = mesh.triangles.iter().map(|t| u16::from(right(t))).collect();
        for known in [true, false] {
            with_full(&mesh, known, |full| {
                let patches = Patches::new(full, full.triangles.len());
                assert_eq!(patches.can_repaint(), known);
                let rims_at = |x: f32| {
                    let on = |edge: &&RimEdge| edge.ends.iter().all(|&v| mesh.positions[v as usize][0] == x);
                    patches.rim_edges(full).iter().filter(on).count()
                };
                assert_eq!(rims_at(2.0), if known { 0 } else { 4 }, "two rows, both sides");
                assert_eq!([rims_at(0.0), rims_at(4.0), rims_at(6.0)], [2, 4, 2]);
            });
        }
    }

    #[test]
    fn tints_of_one_material_part_at_a_rim() {
        let mut mesh = grid(6, 2, |_, _| 0.0, |x, _| x == 4);
        // One chart: the texture runs on.
        mesh.uvs = mesh.positions.iter().map(|p| [p[0] / 6.0, p[1] / 2.0]).collect();
        for t in mesh.triangles.clone() {
            if t.iter().all(|&v| mesh.positions[v as usize][0] >= 4.0) {
                t.iter().for_each(|&v| mesh.colors[v as usize] = [255, 0, 0, 255]);
            }
        }
        with_full(&mesh, true, |full| {
            assert!(full.charts.of_triangle.iter().all(|&chart| chart == 0), "one chart");
            let rims = Patches::new(full, full.triangles.len()).rim_edges(full);
            let on = |x: f32| move |edge: &&RimEdge| edge.ends.iter().all(|&v| full.mesh.positions[v as usize][0] == x);
            assert_eq!([2.0, 4.0].map(|x| rims.iter().filter(on(x)).count()), [0, 4]);
        });
    }

    #[test]
    fn repainted_triangles_change_their_patch() {
        let mut mesh = grid(6, 2, |_, _| 0.0, |_, _| false);
        let count = mesh.materials.len();
        mesh.materials[count / 2..].fill(1);
        with_full(&mesh, true, |full| {
            let mut patches = Patches::new(full, count);
            let of = |material: u16| full.materials.iter().position(|&m| m == material).expect("both are there");
            let look = full.plain_look(of(1) as u32).expect("plain");
            assert_ne!(patches.of_level[of(0)], patches.of_level[of(1)]);
            patches.repaint(full, &[(of(0), look)]);
            assert_eq!(patches.of_level[of(0)], patches.of_level[of(1)]);
        });
    }
}
