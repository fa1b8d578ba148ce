//! Which bucket each instance is drawn from, and how far it is on the way there.

use crate::dispatch::{DOT_VERTICES, IMPOSTOR_VERTICES};
use crate::impostors::{impostor_share, stands_in};
use crate::{Buckets, CullRecord, FillState, FrameConfig, InstanceRecord, LodChoice, MorphRecord};

/// The bucket of each instance's level: the finest quantised level of at most as many vertices as were chosen, dots included; and
/// its morph (dots have none). Who is small on the screen is in the bucket of their impostor, or in that of both; there the fraction says
/// which share of the pixels the impostor has.
///
/// `culled`, `choices`: one per instance, zeros when culled; `fill`: of `fill_budget`. Returns one key per instance, culled ones
/// get [`Buckets::nobody`]; and one morph: with `config.morph`, the fraction says where the water stands between the level and
/// the next finer one (full detail has as far to go as it came), 0 at the level itself. There the vertices that the coarser
/// level lacks lie where that has them, so a level comes and goes without a jump. Without, fractions are 1.
///
/// Paper: Park & Han 2009 §3.2 sorts by LOD. Departs: by character and level, 64 levels instead of three, which morph.
/// Twin: `shaders/stages/key_instances.wgsl`, entry point `key_levels`. Keys equal, fractions within [`FRACTION_BOUND`].
pub fn key_instances(
    buckets: &Buckets,
    instances: &[InstanceRecord],
    culled: &[CullRecord],
    choices: &[LodChoice],
    fill: &FillState,
    config: &FrameConfig,
) -> (Vec<u32>, Vec<MorphRecord>) {
    let key = |i: usize| {
        if choices[i].vertex_count == 0 {
            return (buckets.nobody(), MorphRecord::default());
        }
        let (character, area_px2) = (instances[i].character, culled[i].area_px2);
        let coarsest = buckets.records[buckets.at(character, 0) as usize].vertex_count;
        let is_dots = choices[i].vertex_count == DOT_VERTICES;
        if !is_dots && stands_in(coarsest, area_px2, config.impostor_area_px2) {
            let fades = choices[i].vertex_count > IMPOSTOR_VERTICES;
            let fraction = if fades { impostor_share(area_px2, config.impostor_area_px2) } else { 1.0 };
            return (buckets.impostor(character, fades), MorphRecord { coarser_vertex_count: 0, fraction });
        }
        let key = buckets.fitting(instances[i].character, choices[i].vertex_count);
        if key >= buckets.mesh_count {
            return (key, MorphRecord { coarser_vertex_count: 0, fraction: 1.0 });
        }
        let level = &buckets.records[key as usize];
        let finer = match buckets.finer(instances[i].character, key) {
            Some(finer) => buckets.records[finer as usize].vertex_count,
            None => 2 * level.vertex_count - level.coarser_vertex_count,
        };
        let above = culled[i].weight * f32::from_bits(fill.smooth_bits) - level.vertex_count as f32;
        let fraction = (above / (finer - level.vertex_count).max(1) as f32).clamp(0.0, 1.0);
        let fraction = if config.morph == 1 { fraction } else { 1.0 };
        (key, MorphRecord { coarser_vertex_count: level.coarser_vertex_count, fraction })
    };
    (0..instances.len()).map(key).unzip()
}

/// How far GPU and CPU may differ in a fraction: a product and a difference of large numbers may be fused, a quotient is off by
/// 2.5 ulp.
pub const FRACTION_BOUND: f32 = 1e-3;

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
