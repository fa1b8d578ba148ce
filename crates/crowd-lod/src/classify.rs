//! Finds seams and borders, and classes every wedge as fixed, companioned or regular (Peng 2011 §4.2).

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

    let edges = sorted_edges(split);
    for group in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
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
        report.border_count += if on_border[p] { size } else { 0 };
        report.seam_position_count += u32::from(size > 1);
        wedge_class[group].fill(class);
    }
    Classes { edge_kinds, non_manifold, wedge_class, report }
}

/// Every triangle side as (lower position, higher position, `triangle * 3 + corner`), sorted.
fn sorted_edges(split: &SplitMesh) -> Vec<(u32, u32, u32)> {
    let mut edges: Vec<(u32, u32, u32)> = (0..split.triangles.len() as u32 * 3)
        .into_par_iter()
        .map(|corner| {
            let triangle = split.triangles[corner as usize / 3];
            let a = split.position_of(triangle[corner as usize % 3]);
            let b = split.position_of(triangle[(corner as usize + 1) % 3]);
            (a.min(b), a.max(b), corner)
        })
        .collect();
    edges.par_sort_unstable();
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
    // Sides seen from each position: (position, neighbour, triangle).
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(split.triangles.len() * 6);
    for (t, triangle) in split.triangles.iter().enumerate() {
        let [a, b, c] = triangle.map(|v| split.position_of(v));
        for (at, to) in [(a, b), (a, c), (b, a), (b, c), (c, a), (c, b)] {
            sides.push((at, to, t as u32));
        }
    }
    sides.par_sort_unstable();
    let mut group_of_triangle = vec![0_u32; split.triangles.len()];
    let mut parents: Vec<u32> = Vec::new();
    for around in sides.chunk_by(|a, b| a.0 == b.0) {
        // Triangles around this position, joined when they share a neighbour.
        parents.clear();
        let mut fan_count = 0;
        for &(_, _, t) in around {
            group_of_triangle[t as usize] = u32::MAX;
        }
        for &(_, _, t) in around {
            if group_of_triangle[t as usize] == u32::MAX {
                group_of_triangle[t as usize] = parents.len() as u32;
                parents.push(parents.len() as u32);
                fan_count += 1;
            }
        }
        for pair in around.windows(2).filter(|pair| pair[0].1 == pair[1].1) {
            let a = root(&mut parents, group_of_triangle[pair[0].2 as usize]);
            let b = root(&mut parents, group_of_triangle[pair[1].2 as usize]);
            if a != b {
                parents[a.max(b) as usize] = a.min(b);
                fan_count -= 1;
            }
        }
        non_manifold[around[0].0 as usize] |= fan_count > 1;
    }
}

fn root(parents: &mut [u32], mut at: u32) -> u32 {
    while parents[at as usize] != at {
        parents[at as usize] = parents[parents[at as usize] as usize];
        at = parents[at as usize];
    }
    at
}
