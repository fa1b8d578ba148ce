//! Boxes and spheres that hold a character in every frame of each clip, refitted levels with it.

use crate::bake_levels::BakedLevels;
use crate::views::QuantizedMesh;
use crowd_anim::{Bounds, SampledClip, animated_bounds, union_bounds};
use crowd_lod::CollapseOrder;
use crowd_pack::VertexRecord;
use rayon::prelude::*;

/// Of the order's vertices, and with them of all levels that have no vertices of their own.
pub(crate) fn bound_clips(
    mesh: &QuantizedMesh,
    order: &CollapseOrder,
    clips: &[SampledClip],
    joint_count: usize,
) -> Vec<Bounds> {
    let used = || order.vertex_source.iter().map(|vertex| *vertex as usize);
    let positions: Vec<_> = used().map(|vertex| mesh.positions[vertex]).collect();
    let joints: Vec<_> = used().map(|vertex| mesh.joints[vertex]).collect();
    let weights: Vec<_> = used().map(|vertex| mesh.weights[vertex]).collect();
    let bound = |clip: &SampledClip| animated_bounds(&positions, &joints, &weights, &clip.palettes, joint_count);
    clips.par_iter().map(bound).collect()
}

/// Grows the clips' bounds until they hold the vertices of refitted levels as well, which were moved out of full detail's surface.
pub(crate) fn hold_refitted(bounds: &mut [Bounds], levels: &BakedLevels, clips: &[SampledClip], joint_count: usize) {
    let own = || levels.discrete.iter().filter_map(|discrete| discrete.level.own.as_deref()).flatten();
    if own().next().is_none() {
        return;
    }
    let positions: Vec<_> = own().map(|vertex| vertex.position).collect();
    let joints: Vec<_> = own().map(VertexRecord::joint_indices).collect();
    let weights: Vec<_> = own().map(VertexRecord::weights_f32).collect();
    bounds.par_iter_mut().zip(clips).for_each(|(bounds, clip)| {
        let refitted = animated_bounds(&positions, &joints, &weights, &clip.palettes, joint_count);
        *bounds = union_bounds(&[*bounds, refitted]);
    });
}
