// The indirect draw's arguments and the frame's totals. One thread. Twin: crowd-stages/src/cpu/write_draw_args.rs.

@group(0) @binding(0) var<uniform> config: FrameConfig;
@group(0) @binding(1) var<uniform> capacities: Capacities;
@group(0) @binding(2) var<storage, read> sums: WeightSums;
@group(0) @binding(3) var<storage, read> choices: array<LodChoice>;
@group(0) @binding(4) var<storage, read> bases: array<InstanceBase>;
@group(0) @binding(5) var<storage, read> counts: InstanceBase;
@group(0) @binding(6) var<storage, read_write> draw_args: DrawArgs;
@group(0) @binding(7) var<storage, read_write> totals: FrameTotals;

// Instances that the buffers hold: the first that is not kept, by bisection.
fn kept_instances() -> u32 {
    var low = 0u;
    var high = config.instance_count;
    while low < high {
        let middle = low + (high - low) / 2u;
        if is_kept(bases[middle], choices[middle], capacities) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

@compute @workgroup_size(1)
fn write_draw_args() {
    var overflow = 0u;
    if sums.min_vertex_count > config.budget {
        overflow |= OVERFLOW_BUDGET;
    }
    if counts.vertex_base > capacities.vertex_count {
        overflow |= OVERFLOW_VERTICES;
    }
    if counts.triangle_base > capacities.triangle_count {
        overflow |= OVERFLOW_TRIANGLES;
    }
    var drawn = vec2u(counts.vertex_base, counts.triangle_base);
    let kept = kept_instances();
    if kept < config.instance_count {
        drawn = vec2u(bases[kept].vertex_base, bases[kept].triangle_base);
    }
    draw_args = DrawArgs(drawn.y * 3u, 1u, 0u, 0, 0u);
    totals = FrameTotals(
        sums.visible_count,
        drawn.x,
        drawn.y,
        sums.min_vertex_count,
        overflow,
        counts.vertex_base,
        counts.triangle_base,
        select(0u, 1u, drawn.y > 0u),
        sums.wanted_count,
        threshold_px(config.weight, sums.water_bits),
        0u,
        config.instance_count - sums.visible_count,
        0u,
    );
}
