//! What the one draw call draws, and what the frame came to.

use super::{is_kept, threshold_px};
use crate::{Capacities, DrawArgs, FrameConfig, FrameTotals, InstanceBase, LodChoice, WeightSums, overflow};

/// Arguments of the one indexed indirect draw, and the frame's totals with overflow bits.
///
/// `end`: the sums returned by `scan_counts`. When buffers are too small, the draw ends with the last instance that fits as a
/// whole; a bit says which buffer, `needed_*` how much it should hold.
///
/// Paper: Dong 2019 §5 ("a single VBO and IBO"). Departs: Dong draws per instance from them, we draw once. The papers have no
/// word on overflow.
///
/// Twin: `shaders/stages/write_draw_args.wgsl`. Equal.
pub fn write_draw_args(
    choices: &[LodChoice],
    bases: &[InstanceBase],
    end: InstanceBase,
    sums: &WeightSums,
    capacities: &Capacities,
    config: &FrameConfig,
) -> (DrawArgs, FrameTotals) {
    let first_dropped = (0..choices.len()).find(|&i| !is_kept(bases[i], choices[i], capacities));
    let drawn = first_dropped.map_or(end, |i| bases[i]);
    let bit = |set: bool, bit: u32| if set { bit } else { 0 };
    let args = DrawArgs {
        index_count: drawn.triangle_base * 3,
        instance_count: 1,
        first_index: 0,
        base_vertex: 0,
        first_instance: 0,
    };
    let totals = FrameTotals {
        visible_count: sums.visible_count,
        vertex_count: drawn.vertex_base,
        triangle_count: drawn.triangle_base,
        min_vertex_count: sums.min_vertex_count,
        overflow: bit(sums.min_vertex_count > config.budget, overflow::BUDGET)
            | bit(end.vertex_base > capacities.vertex_count, overflow::VERTICES)
            | bit(end.triangle_base > capacities.triangle_count, overflow::TRIANGLES),
        needed_vertices: end.vertex_base,
        needed_triangles: end.triangle_base,
        draw_count: u32::from(drawn.triangle_base > 0),
        wanted_count: sums.wanted_count,
        threshold_px: threshold_px(sums, config),
        occluded_count: 0,
        outside_count: choices.len() as u32 - sums.visible_count,
        refused_count: 0,
    };
    (args, totals)
}
