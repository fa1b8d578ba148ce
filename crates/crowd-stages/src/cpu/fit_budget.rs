//! The budget is hard: shrink what was wanted until it fits, then look up the levels.

use crate::{CrowdData, FrameConfig, InstanceRecord, LodChoice, WeightSums};
use crowd_pack::LodRecord;

/// Turns wanted vertex counts into levels that add up to at most the budget.
///
/// `lods`: the LOD tables, the data's or those of quantised levels only. `wanted`: one per instance, 0 when culled. When the sum exceeds N, every instance gives up the same share of what it has
/// above its coarsest level: `k' = min + floor((k - min) * (N - sum of min) / (sum of k - sum of min))`. When the coarsest
/// levels alone exceed N, everyone keeps just that ([`crate::overflow::BUDGET`] is set by `write_draw_args`). The level is
/// looked up in the character's LOD table, which never gives more than `k'`. Completes `sums`; returns one choice per instance.
///
/// Paper: "the total triangle count of all characters is smaller than a predefined maximal count" (Peng 2011 §5.1), for
/// vertices; and the mapping of k to q. Departs: the papers do not say how they keep the promise when levels are clamped.
/// The share is a whole number of 2^-32, rounded down, so no rounding can break the budget.
///
/// Twin: `shaders/stages/fit_budget.wgsl`. Equal.
pub fn fit_budget(
    data: &CrowdData,
    lods: &[LodRecord],
    instances: &[InstanceRecord],
    wanted: &[u32],
    sums: &mut WeightSums,
    config: &FrameConfig,
) -> Vec<LodChoice> {
    let total = wanted.iter().fold(0u32, |sum, k| sum.saturating_add(*k));
    let coarsest = sums.min_vertex_count;
    sums.wanted_count = total;
    sums.is_scaled = u32::from(total > config.budget);
    sums.share = 0;
    if total > config.budget && config.budget > coarsest {
        sums.share = (u64::from(config.budget - coarsest) << 32).div_euclid(u64::from(total - coarsest)) as u32;
    }

    let choose = |(instance, wanted): (&InstanceRecord, &u32)| {
        if *wanted == 0 {
            return LodChoice::default();
        }
        let character = &data.characters[instance.character as usize];
        let least = character.min_vertex_count;
        let k = match sums.is_scaled {
            0 => *wanted,
            _ => least + ((u64::from(wanted - least) * u64::from(sums.share)) >> 32) as u32,
        };
        let level = lods[character.lod_offset as usize + k as usize];
        LodChoice { vertex_count: level.vertex_count, triangle_count: level.triangle_count }
    };
    instances.iter().zip(wanted).map(choose).collect()
}
