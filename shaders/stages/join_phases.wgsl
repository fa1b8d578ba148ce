// Between the phases of occlusion culling: how much water the second may pour, and what both came to.
// Twin: crowd-stages/src/cpu/join_phases.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<storage, read> sums: WeightSums;
@group(0) @binding(2) var<storage, read> second_sums: WeightSums;
@group(0) @binding(3) var<storage, read> fill: FillState;
@group(0) @binding(4) var<storage, read> tally: SightTally;
@group(0) @binding(5) var<storage, read_write> second_fill: FillState;
@group(0) @binding(6) var<storage, read> first_totals: FrameTotals;
@group(0) @binding(7) var<storage, read_write> totals: FrameTotals;

// Newly seen ones take the step from their coarsest level to the first phase's water, the first of them, as long as it fits.
@compute @workgroup_size(1)
fn begin_second() {
    second_fill.low_bits = 0u;
    second_fill.high_bits = fill.low_bits;
    second_fill.goal = config.budget;
    let first = spent(vec2u(first_totals.vertex_count, first_totals.triangle_count), config.budget_in);
    second_fill.low_count = saturating_add(first, second_sums.min_vertex_count);
}

@compute @workgroup_size(1)
fn join() {
    let vertex_count = saturating_add(first_totals.vertex_count, totals.vertex_count);
    let triangle_count = saturating_add(first_totals.triangle_count, totals.triangle_count);
    let visible_count = first_totals.visible_count + totals.visible_count;
    let occluded_count = tally.hidden_count - second_sums.visible_count;
    let unskinned = (first_totals.overflow | totals.overflow) & OVERFLOW_VERTICES;
    totals = FrameTotals(
        visible_count,
        vertex_count,
        triangle_count,
        saturating_add(sums.min_vertex_count, second_sums.min_vertex_count),
        select(0u, OVERFLOW_BUDGET, spent(vec2u(vertex_count, triangle_count), config.budget_in) > config.budget) | unskinned,
        vertex_count,
        triangle_count,
        first_totals.draw_count + totals.draw_count,
        first_totals.wanted_count,
        first_totals.threshold_px,
        occluded_count,
        config.instance_count - visible_count - occluded_count,
        0u,
    );
}
