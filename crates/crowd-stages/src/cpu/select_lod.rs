//! Eq. 1: how many vertices each instance should have.

use crate::{CrowdData, CullRecord, FrameConfig, InstanceRecord, WeightSums};

/// Gives every visible instance the vertex count of Eq. 1, between its coarsest level and full detail.
///
/// `culled`: one per instance; `sums`: of the same records. Returns one count per instance, 0 when culled:
/// `k = floor(N * w / sum of w)`. Clamping up to the coarsest level can push the sum above N; `fit_budget` sees to that.
///
/// Paper: Peng 2011 Eq. 1 (§5.1), Dong 2019 Eq. 1 (§4.1). Departs: rounded down and clamped; the papers do not say what
/// happens below the coarsest level. What near instances cannot use above full detail is not handed to others.
///
/// Twin: `shaders/stages/select_lod.wgsl`. Equal for equal weights, or one vertex apart (for budgets above 2^24, one step of
/// the float) where the product lies within [`QUOTIENT_BOUND`] of an integer (WGSL allows a division 2.5 ulp).
pub fn select_lod(
    data: &CrowdData,
    instances: &[InstanceRecord],
    culled: &[CullRecord],
    sums: &WeightSums,
    config: &FrameConfig,
) -> Vec<u32> {
    let choose = |(instance, cull): (&InstanceRecord, &CullRecord)| {
        if cull.visible == 0 {
            return 0;
        }
        let character = &data.characters[instance.character as usize];
        let share = (cull.weight / sums.weight).min(1.0);
        let k = (config.budget as f32 * share).floor().clamp(0.0, character.vertex_count as f32);
        (k as u32).clamp(character.min_vertex_count, character.vertex_count)
    };
    instances.iter().zip(culled).map(choose).collect()
}

/// Relative error of the unrounded count: 2.5 ulp of the division and half an ulp of the product on the GPU, half an ulp
/// each here.
pub const QUOTIENT_BOUND: f32 = 4.0 * f32::EPSILON;
