// Which instances the frame's buffers hold: those whose part ends inside both. Ends never decrease from one instance to
// the next, so the kept instances are the first ones.

fn is_kept(base: InstanceBase, choice: LodChoice, capacities: Capacities) -> bool {
    return saturating_add(base.vertex_base, choice.vertex_count) <= capacities.vertex_count
        && saturating_add(base.triangle_base, choice.triangle_count) <= capacities.triangle_count;
}
