//! Between the phases of occlusion culling: water for the second, and what both came to.

use crate::{FillState, FrameConfig, FrameTotals, SightTally, WeightSums, overflow};

/// The state in which `fill_budget` gives newly seen instances their levels: those take the step from their coarsest level to
/// the first phase's water, the first of them, as long as it fits what the first phase has left of N.
///
/// `first`: totals of the first phase; `second_sums`: of the newly seen; `config`: its budget.
///
/// Twin: `shaders/stages/join_phases.wgsl`, entry point `begin_second`. Equal.
pub fn begin_second(
    first: &FrameTotals,
    second_sums: &WeightSums,
    fill: &FillState,
    config: &FrameConfig,
) -> FillState {
    let low_count = config.spent(first.vertex_count, first.triangle_count).saturating_add(second_sums.min_vertex_count);
    FillState { low_bits: 0, high_bits: fill.low_bits, low_count, goal: config.budget, ..Default::default() }
}

/// What both phases came to; `tally`: of `recall_seen`, who waited. Beyond N, by newcomers' coarsest levels alone, sets [`overflow::BUDGET`]; either
/// phase's [`overflow::VERTICES`] stays.
///
/// Twin: `shaders/stages/join_phases.wgsl`, entry point `join`. Equal.
pub fn join_phases(
    first: &FrameTotals,
    second: &FrameTotals,
    sums: &WeightSums,
    second_sums: &WeightSums,
    tally: &SightTally,
    config: &FrameConfig,
) -> FrameTotals {
    let vertex_count = first.vertex_count.saturating_add(second.vertex_count);
    let triangle_count = first.triangle_count.saturating_add(second.triangle_count);
    let visible_count = first.visible_count + second.visible_count;
    let occluded_count = tally.hidden_count - second_sums.visible_count;
    let unskinned = (first.overflow | second.overflow) & overflow::VERTICES;
    FrameTotals {
        visible_count,
        vertex_count,
        triangle_count,
        min_vertex_count: sums.min_vertex_count.saturating_add(second_sums.min_vertex_count),
        overflow: unskinned
            | if config.spent(vertex_count, triangle_count) > config.budget { overflow::BUDGET } else { 0 },
        needed_vertices: vertex_count,
        needed_triangles: triangle_count,
        draw_count: first.draw_count + second.draw_count,
        wanted_count: first.wanted_count,
        threshold_px: first.threshold_px,
        occluded_count,
        outside_count: config.instance_count - visible_count - occluded_count,
        refused_count: 0,
    }
}
