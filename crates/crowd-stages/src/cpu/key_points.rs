//! Whether an instance is drawn as points, and as how many.

use crate::dispatch::POINT_LEVELS;
use crate::{Buckets, CullRecord, InstanceRecord};

/// Keys of the instances: the bucket of the coarsest density that has at least a point for each pixel of the instance's sphere;
/// of full detail where none has, or none is coarser; [`Buckets::nobody`] when culled.
///
/// A sphere has four or five times the pixels of a standing person in it, half of the points are on the back, so there are about
/// two points for each pixel that the person covers, up to eight where the next density is not quite enough.
/// `buckets`: of [`Buckets::with_points`]; `culled`: one per instance.
///
/// Paper: Dong 2019 §6.2, "selected based on its distance to the camera"; the figures are ours.
/// Twin: `shaders/stages/key_points.wgsl`. Equal.
pub fn key_points(buckets: &Buckets, instances: &[InstanceRecord], culled: &[CullRecord]) -> Vec<u32> {
    let key = |(instance, cull): (&InstanceRecord, &CullRecord)| {
        if cull.visible == 0 {
            return buckets.nobody();
        }
        let first = buckets.mesh_count + instance.character * POINT_LEVELS;
        let suffices = |bucket: &u32| {
            let points = buckets.records[*bucket as usize].vertex_count;
            points > 0 && points as f32 >= cull.area_px2
        };
        let levels = buckets.sets[instance.character as usize].level_count;
        let full_detail = buckets.at(instance.character, levels - 1);
        (first..first + POINT_LEVELS).find(suffices).unwrap_or(full_detail)
    };
    instances.iter().zip(culled).map(key).collect()
}
