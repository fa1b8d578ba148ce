//! Which bucket each instance is drawn from.

use crate::{Buckets, CullRecord, InstanceRecord, LodChoice};

/// The bucket of each instance's level: the finest quantised level of at most as many vertices as were chosen.
///
/// `choices`: one per instance, zeros when culled. Returns one key per instance; culled ones get [`Buckets::nobody`].
///
/// Paper: Park & Han 2009 §3.2 sorts by LOD; Departs: by character and level, 64 levels instead of three.
/// Twin: `shaders/stages/key_instances.wgsl`, entry point `key_levels`. Equal.
pub fn key_instances(buckets: &Buckets, instances: &[InstanceRecord], choices: &[LodChoice]) -> Vec<u32> {
    let key = |(instance, choice): (&InstanceRecord, &LodChoice)| match choice.vertex_count {
        0 => buckets.nobody(),
        count => buckets.fitting(instance.character, count),
    };
    instances.iter().zip(choices).map(key).collect()
}

/// The bucket of each visible instance's full detail.
///
/// Twin: `shaders/stages/key_instances.wgsl`, entry point `key_full_detail`. Equal.
pub fn key_full_detail(buckets: &Buckets, instances: &[InstanceRecord], culled: &[CullRecord]) -> Vec<u32> {
    let key = |(instance, cull): (&InstanceRecord, &CullRecord)| match cull.visible {
        0 => buckets.nobody(),
        _ => buckets.at(instance.character, buckets.sets[instance.character as usize].level_count - 1),
    };
    instances.iter().zip(culled).map(key).collect()
}
