//! Where each instance's vertices and triangles go.

use crate::{InstanceBase, LodChoice};

/// Exclusive prefix sums of vertex and triangle counts: each instance's place in the frame's buffers.
///
/// Returns one base per instance and the sums over all. Sums saturate at `u32::MAX`, which no buffer holds, so what lies
/// beyond is seen as overflow.
///
/// Paper: Dong 2019 §5.3 (Thrust's prefix sum over the vertex and triangle counts).
/// Twin: `shaders/stages/scan_counts.wgsl`. Equal.
pub fn scan_counts(choices: &[LodChoice]) -> (Vec<InstanceBase>, InstanceBase) {
    let mut next = InstanceBase::default();
    let bases = choices
        .iter()
        .map(|choice| {
            let base = next;
            next.vertex_base = next.vertex_base.saturating_add(choice.vertex_count);
            next.triangle_base = next.triangle_base.saturating_add(choice.triangle_count);
            base
        })
        .collect();
    (bases, next)
}
