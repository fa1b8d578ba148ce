//! Puts vertices and triangles in the order of the collapses, last first (Peng 2011 §5.2).

use crate::collapse::Steps;
use crate::split_seams::SplitMesh;
use crate::{CollapseOrder, FrameReport, Level, Obstacle, SeamReport, VertexClass};

/// The order: what never collapses first, then the steps from the last to the first. What one step drops lies together,
/// so companions are never parted by a level.
pub(crate) fn reorder_by_collapse(
    split: &SplitMesh,
    wedge_class: &[VertexClass],
    steps: &Steps,
    seams: SeamReport,
) -> CollapseOrder {
    let vertex_order = last_first(split.variant_wedge.len(), &steps.dropped_ends, |i| steps.dropped[i].0);
    let triangle_order = last_first(split.triangles.len(), &steps.removed_ends, |i| steps.removed[i]);

    let kept = &vertex_order[..vertex_order.len() - steps.dropped.len()];

    let mut vertex_remap = vec![0_u32; vertex_order.len()];
    for (new, &old) in vertex_order.iter().enumerate() {
        vertex_remap[old as usize] = new as u32;
    }
    let mut collapse_map: Vec<u32> = (0..vertex_order.len() as u32).collect();
    for &(from, to) in &steps.dropped {
        collapse_map[vertex_remap[from as usize] as usize] = vertex_remap[to as usize];
    }
    CollapseOrder {
        vertex_source: vertex_order.iter().map(|&v| split.place_source(v)).collect(),
        attribute_source: vertex_order.iter().map(|&v| split.variant_source[v as usize]).collect(),
        normal_source: vertex_order.iter().map(|&v| split.variant_normal_source[v as usize]).collect(),
        vertex_materials: vertex_order.iter().map(|&v| split.variant_material[v as usize]).collect(),
        vertex_classes: vertex_order.iter().map(|&v| class_of(split, wedge_class, v)).collect(),
        triangles: triangle_order
            .iter()
            .map(|&t| split.triangles[t as usize].map(|v| vertex_remap[v as usize]))
            .collect(),
        triangle_source: triangle_order.iter().map(|&t| split.triangle_source[t as usize]).collect(),
        collapse_map,
        levels: list_levels(split, steps),
        seams: SeamReport { hurried_collapse_count: steps.hurried_count, ..seams },
        blocked: steps.blocked,
        obstacles: kept
            .iter()
            .map(|&v| steps.obstacles[split.position_of(v) as usize].unwrap_or(Obstacle::Fixed))
            .collect(),
        frames: FrameReport::default(),
    }
}

/// The class at full detail; a stand-in lies on a seam.
fn class_of(split: &SplitMesh, wedge_class: &[VertexClass], variant: u32) -> VertexClass {
    let wedge = split.variant_wedge[variant as usize] as usize;
    wedge_class.get(wedge).copied().unwrap_or(VertexClass::Companion)
}

/// `0..count`, those in no step first in their order, then the steps from the last to the first.
fn last_first(count: usize, ends: &[u32], element: impl Fn(usize) -> u32) -> Vec<u32> {
    let total = ends.last().copied().unwrap_or(0) as usize;
    let mut kept = vec![true; count];
    for i in 0..total {
        kept[element(i) as usize] = false;
    }
    let mut order: Vec<u32> = (0..count as u32).filter(|&i| kept[i as usize]).collect();
    for step in (0..ends.len()).rev() {
        let start = if step == 0 { 0 } else { ends[step - 1] as usize };
        order.extend((start..ends[step] as usize).map(&element));
    }
    order
}

fn list_levels(split: &SplitMesh, steps: &Steps) -> Vec<Level> {
    let vertex_count = split.variant_wedge.len() as u32;
    let triangle_count = split.triangles.len() as u32;
    let mut levels = vec![Level { vertex_count, triangle_count, error_m: 0.0 }];
    let mut worst = 0.0_f32;
    for step in 0..steps.costs.len() {
        worst = worst.max(steps.costs[step]);
        levels.push(Level {
            vertex_count: vertex_count - steps.dropped_ends[step],
            triangle_count: triangle_count - steps.removed_ends[step],
            error_m: worst.sqrt(),
        });
    }
    levels.reverse();
    levels
}
