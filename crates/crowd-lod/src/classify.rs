//! Finds seams and borders, and classes every wedge as fixed, companioned or regular (Peng 2011 §4.2).

use crate::lists::Lists;
use crate::split_seams::SplitMesh;
use crate::{SeamReport, VertexClass};
use rayon::prelude::*;

/// What an edge of a triangle is at full detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum EdgeKind {
    /// Two triangles with the same wedges at both ends.
    Interior,
    /// Two triangles, but other wedges at one end at least.
    Seam,
    /// One triangle.
    Border,
    /// More than two triangles.
    NonManifold,
}

/// Classes and what they rest on.
#[derive(Debug)]
pub(crate) struct Classes {
    /// For each triangle, the kind of edge from corner `i` to corner `i + 1`.
    pub edge_kinds: Vec<[EdgeKind; 3]>,
    /// Positions where the surface is no (half-)disc: on an edge with more than two triangles, or where several fans meet.
    pub non_manifold: Vec<bool>,
    /// For each wedge, its class.
    pub wedge_class: Vec<VertexClass>,
    /// Counts.
    pub report: SeamReport,
}

/// Classes every wedge once, at full detail.
///
/// Paper: Peng 2011 §4.2. Departs: non-manifold positions, of which the paper says nothing, are fixed as borders are.
pub(crate) fn classify_wedges(split: &SplitMesh) -> Classes {
    let position_count = split.position_source.len();
    let mut on_border = vec![false; position_count];
    let mut non_manifold = vec![false; position_count];
    let mut edge_kinds = vec![[EdgeKind::Interior; 3]; split.triangles.len()];
    let mut non_manifold_edge_count = 0;

    for group in list_edges(split).entries().chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (low, high, _) = group[0];
        let kind = match group {
            [_] => EdgeKind::Border,
            [a, b] if edge_wedges(split, a.2) == edge_wedges(split, b.2) => EdgeKind::Interior,
            [_, _] => EdgeKind::Seam,
            _ => EdgeKind::NonManifold,
        };
        for p in [low as usize, high as usize] {
            on_border[p] |= kind == EdgeKind::Border;
            non_manifold[p] |= kind == EdgeKind::NonManifold;
        }
        non_manifold_edge_count += u32::from(kind == EdgeKind::NonManifold);
        for &(_, _, corner) in group {
            edge_kinds[corner as usize / 3][corner as usize % 3] = kind;
        }
    }
    mark_meeting_fans(split, &mut non_manifold);

    let offsets = split.wedge_offsets();
    let mut report = SeamReport {
        position_count: position_count as u32,
        vertex_count: split.variant_wedge.len() as u32,
        wedge_count: split.wedge_position.len() as u32,
        degenerate_triangle_count: split.degenerate_count,
        duplicate_triangle_count: split.duplicate_count,
        coincident_triangle_count: split.coincident_count,
        non_manifold_edge_count,
        ..SeamReport::default()
    };
    let mut wedge_class = vec![VertexClass::Regular; split.wedge_position.len()];
    for p in 0..position_count {
        let group = offsets[p] as usize..offsets[p + 1] as usize;
        let size = group.len() as u32;
        let class = match size {
            _ if on_border[p] || non_manifold[p] => VertexClass::Fixed,
            1 => VertexClass::Regular,
            2 => VertexClass::Companion,
            _ => VertexClass::Fixed,
        };
        match class {
            VertexClass::Fixed => report.fixed_count += size,
            VertexClass::Companion => report.companion_count += size,
            VertexClass::Regular => report.regular_count += size,
        }
        report.non_manifold_position_count += u32::from(non_manifold[p]);
        report.border_count += if on_border[p] { size } else { 0 };
        report.seam_position_count += u32::from(size > 1);
        wedge_class[group].fill(class);
    }
    Classes { edge_kinds, non_manifold, wedge_class, report }
}

/// Every triangle side as (lower position, higher position, `triangle * 3 + corner`), by the former and sorted.
fn list_edges(split: &SplitMesh) -> Lists<(u32, u32, u32)> {
    let sides = split.triangles.iter().enumerate().flat_map(|(t, triangle)| {
        let [a, b, c] = triangle.map(|v| split.position_of(v));
        let t = 3 * t as u32;
        [(a.min(b), a.max(b), t), (b.min(c), b.max(c), t + 1), (c.min(a), c.max(a), t + 2)]
    });
    // By lower position in one pass; what is left to sort is a handful each.
    let mut edges = Lists::fill(split.position_source.len(), sides.map(|side| (side.0, side)));
    edges.sort_each();
    edges
}

/// The two wedges of a triangle side, that at the lower position first.
fn edge_wedges(split: &SplitMesh, corner: u32) -> [u32; 2] {
    let triangle = split.triangles[corner as usize / 3];
    let a = split.variant_wedge[triangle[corner as usize % 3] as usize];
    let b = split.variant_wedge[triangle[(corner as usize + 1) % 3] as usize];
    // Wedge ids ascend with their position.
    [a.min(b), a.max(b)]
}

/// Marks positions where several fans of triangles meet in a point (bow-ties).
fn mark_meeting_fans(split: &SplitMesh, non_manifold: &mut [bool]) {
    let corners = |t: u32| split.triangles[t as usize].map(|v| split.position_of(v));
    let incident = Lists::incident(non_manifold.len(), (0..split.triangles.len() as u32).map(corners));
    let room = <(Vec<(u32, u32)>, Vec<u32>)>::default;
    non_manifold.par_iter_mut().enumerate().for_each_init(room, |(sides, parents), (p, non_manifold)| {
        // Triangles around this position, joined when they share a neighbour.
        let around = incident.at(p);
        sides.clear();
        for (i, &t) in around.iter().enumerate() {
            sides.extend(corners(t).into_iter().filter(|&q| q as usize != p).map(|to| (to, i as u32)));
        }
        sides.sort_unstable();
        parents.clear();
        parents.extend(0..around.len() as u32);
        let mut fan_count = around.len();
        for pair in sides.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
            let (a, b) = (root(parents, pair[0].1), root(parents, pair[1].1));
            if a != b {
                parents[a.max(b) as usize] = a.min(b);
                fan_count -= 1;
            }
        }
        *non_manifold |= fan_count > 1;
    });
}

fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        parents[at as usize] = parents[parents[at as usize] as usize];
        at = parents[at as usize];
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::split_seams::split_seams;
    use crate::test_meshes::{TestMesh, cube, grid, uv_sphere};

    fn classify(mesh: &TestMesh) -> (SplitMesh, Classes) {
        let split = split_seams(&mesh.mesh());
        let classes = classify_wedges(&split);
        (split, classes)
    }

    #[test]
    fn sides_are_listed_as_a_plain_sort_lists_them() {
        for mesh in [uv_sphere(9, 7), cube(3), grid(5, 4, |_, _| 0.0, |column, _| column == 2)] {
            let split = split_seams(&mesh.mesh());
            let mut plain = Vec::new();
            for (t, triangle) in split.triangles.iter().enumerate() {
                for i in 0..3 {
                    let [a, b] = [triangle[i], triangle[(i + 1) % 3]].map(|v| split.position_of(v));
                    plain.push((a.min(b), a.max(b), (3 * t + i) as u32));
                }
            }
            plain.sort_unstable();
            assert_eq!(list_edges(&split).entries(), plain);
        }
    }

    /// ```text
    ///  o---o---o---o---o     A grid with a slit (=) from the upper border down to the middle.
    ///  |   |   #   |   |     Its vertices: the one on the border is fixed (border), the next is a
    ///  o---o---s---o---o     companion (s), and the end (e) has one wedge: regular.
    ///  |   |   #   |   |
    ///  o---o---e---o---o
    ///  |   |   |   |   |
    ///  o---o---o---o---o
    /// ```
    #[test]
    fn slit_from_a_border() {
        let mesh = grid(4, 3, |_, _| 0.0, |column, row| column == 2 && row >= 1);
        let (split, classes) = classify(&mesh);
        let class_at = |x: f32, y: f32| {
            let on = |&w: &usize| mesh.positions[split.wedge_source[w] as usize] == [x, y, 0.0];
            (0..split.wedge_position.len()).filter(on).map(|w| classes.wedge_class[w]).collect::<Vec<_>>()
        };
        assert_eq!(class_at(2.0, 1.0), [VertexClass::Regular]);
        assert_eq!(class_at(2.0, 2.0), [VertexClass::Companion; 2]);
        assert_eq!(class_at(2.0, 3.0), [VertexClass::Fixed; 2]);
        let report = classes.report;
        assert_eq!((report.position_count, report.wedge_count), (20, 22));
        assert_eq!((report.fixed_count, report.border_count), (15, 15));
        assert_eq!((report.companion_count, report.regular_count, report.seam_position_count), (2, 5, 2));
    }

    #[test]
    fn corner_of_three_charts_is_fixed_and_edges_are_companions() {
        let (_, classes) = classify(&cube(2));
        let report = classes.report;
        assert_eq!((report.position_count, report.wedge_count), (26, 54));
        assert_eq!(report.fixed_count, 8 * 3, "corners of the cube");
        assert_eq!(report.companion_count, 12 * 2, "middles of its edges");
        assert_eq!(report.regular_count, 6, "middles of its sides");
        assert_eq!(report.border_count, 0);
    }

    #[test]
    fn sphere_poles_are_fixed() {
        let (_, classes) = classify(&uv_sphere(8, 6));
        assert_eq!(classes.report.fixed_count, 2 * 8);
        assert_eq!(classes.report.companion_count, 2 * 5);
    }

    /// ```text
    ///  o       o
    ///  | \   / |
    ///  |   x   |     Two triangles that meet in a point: x is no place to move.
    ///  | /   \ |
    ///  o       o
    /// ```
    #[test]
    fn bow_tie_is_non_manifold() {
        let mut mesh = TestMesh::default();
        for (x, y) in [(0.0, 0.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)] {
            mesh.vertex([x, y, 0.0], [x, y]);
        }
        mesh.triangle([0, 1, 2]);
        mesh.triangle([0, 3, 4]);
        let (_, classes) = classify(&mesh);
        assert_eq!(classes.non_manifold, [true, false, false, false, false]);
        assert_eq!(classes.report.non_manifold_edge_count, 0);
    }

    #[test]
    fn three_pages_on_one_spine_are_non_manifold() {
        let mut mesh = TestMesh::default();
        for (x, y, z) in [(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0)] {
            mesh.vertex([x, y, z], [x, y]);
        }
        for page in 2..5 {
            mesh.triangle([0, 1, page]);
        }
        let (_, classes) = classify(&mesh);
        assert_eq!(classes.report.non_manifold_edge_count, 1);
        assert_eq!(classes.non_manifold, [true, true, false, false, false]);
    }
}
