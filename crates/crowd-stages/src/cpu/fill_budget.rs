//! The budget is spent: water rises over the crowd until its vertices are N.

use crate::dispatch::{ERROR_ENTRIES, ERROR_FIRST_BITS, ERROR_SHIFT, FILL_CANDIDATES};
use crate::dots::least_count;
use crate::{CrowdData, CullRecord, FillState, FrameConfig, InstanceRecord, LodChoice, Weight, WeightSums};
use crowd_pack::LodRecord;

/// Passes of the search.
pub const FILL_PASSES: u32 = 3;
/// 2^80: far above what fills any level, and no product with a weight overflows.
const HIGHEST_BITS: u32 = 0x6780_0000;
const CANDIDATES: usize = FILL_CANDIDATES as usize;

/// Gives every visible instance the level of `k = floor(weight * water)` vertices, the water as high as the budget allows.
///
/// At `water = N / sum of weights` this is Eq. 1; but near instances that are full give what they cannot use to the others,
/// and what the coarsest levels need is taken from all. The height is searched in three passes of sixteen candidates, to 0.3 %. Between
/// the best that fits and the next candidate, which does not, the first instances take the step as long as it fits: less than
/// one instance's step is left over. So the levels add up to at most N, and to all of it but that step, whenever the visible
/// crowd at full detail has more than N vertices and its coarsest levels have not. When those alone exceed N, everyone keeps
/// just that.
///
/// With [`Weight::Error`] the weight is the pixels that a metre takes and the water one over pixels: every instance gets the
/// coarsest quantised level whose bound is at most `1 / (weight * water)` metres, from the error tables. So one threshold in
/// pixels holds for all, the smallest that the budget allows (but for full detail, which has no better).
///
/// `lods`: the LOD tables, the data's, those of quantised levels only, with dots
/// ([`crate::Buckets::quantized_lods`]), or [`crate::Buckets::error_lods`]. `culled`: one per instance. Sets `wanted_count` of
/// `sums` to what Eq. 1 as printed comes to, levels looked up. Returns one choice per instance.
///
/// Paper: Peng 2011 Eq. 1 (§5.1) and Dong 2019 Eq. 1 (§4.1) in their weights. Departs: the papers do not say what becomes of
/// vertices that an instance at full detail cannot use, nor how clamped counts keep below N.
/// Twin: `shaders/stages/fill_budget.wgsl`. Equal for equal weights, but for `wanted_count`, which comes from a quotient.
pub fn fill_budget(
    data: &CrowdData,
    lods: &[LodRecord],
    instances: &[InstanceRecord],
    culled: &[CullRecord],
    sums: &mut WeightSums,
    config: &FrameConfig,
) -> (Vec<LodChoice>, FillState) {
    let level = |i: usize, bits: u32| {
        let character = &data.characters[instances[i].character as usize];
        let product = culled[i].weight * f32::from_bits(bits);
        if config.weight == Weight::Error as u32 {
            return lods[error_entry(instances[i].character, product)];
        }
        let least = least_count(character, culled[i].area_px2, config.dot_area_px2);
        let k = product.min(character.vertex_count as f32).max(least as f32);
        lods[(character.lod_offset + k as u32) as usize]
    };
    let visible: Vec<usize> = (0..instances.len()).filter(|i| culled[*i].visible != 0).collect();
    let sum = |bits: u32| visible.iter().fold(0u32, |sum, i| sum.saturating_add(level(*i, bits).vertex_count));

    let mut fill = begin(sums, config);
    for pass in 0..FILL_PASSES {
        let counts = fill.candidates.map(sum);
        if pass == 0 {
            let plain = counts[CANDIDATES - 1];
            sums.wanted_count = if config.weight == Weight::Error as u32 { 0 } else { plain };
        }
        narrow(&mut fill, &counts, config.budget);
        sums.water_bits = fill.low_bits;
    }

    let mut choices = vec![LodChoice::default(); instances.len()];
    let left = config.budget.saturating_sub(fill.low_count);
    let mut taken = 0u32;
    for i in visible {
        let (low, high) = (level(i, fill.low_bits), level(i, fill.high_bits));
        taken = taken.saturating_add(high.vertex_count - low.vertex_count);
        let LodRecord { vertex_count, triangle_count } = if taken <= left { high } else { low };
        choices[i] = LodChoice { vertex_count, triangle_count };
    }
    (choices, fill)
}

/// Entry of the error tables: 32 for each doubling of one over the metres allowed.
pub(super) fn error_entry(character: u32, per_metre: f32) -> usize {
    let entry = per_metre.to_bits().saturating_sub(ERROR_FIRST_BITS) >> ERROR_SHIFT;
    (character * ERROR_ENTRIES + entry.min(ERROR_ENTRIES - 1)) as usize
}

/// The first candidates: powers of two around Eq. 1's height, then the highest, and last Eq. 1's own.
fn begin(sums: &WeightSums, config: &FrameConfig) -> FillState {
    let exponent = |value: f32| ((value.to_bits() >> 23) & 0xff) as i32 - 127;
    let power = |e: i32| ((e + 127).clamp(0, (HIGHEST_BITS >> 23) as i32) as u32) << 23;
    let around = exponent(config.budget as f32) - exponent(sums.weight);
    let mut candidates: [u32; CANDIDATES] = std::array::from_fn(|c| power(around + c as i32 - 6));
    candidates[CANDIDATES - 2] = HIGHEST_BITS;
    candidates[CANDIDATES - 1] = match sums.weight > 0.0 {
        true => (config.budget as f32 / sums.weight).clamp(0.0, f32::from_bits(HIGHEST_BITS)).to_bits(),
        false => 0,
    };
    let low_count = sums.min_vertex_count;
    FillState { high_bits: HIGHEST_BITS, low_count, candidates, ..Default::default() }
}

/// Between which candidates the budget lies, and the next ones, evenly between those two.
fn narrow(fill: &mut FillState, counts: &[u32; CANDIDATES], budget: u32) {
    let searched = if fill.pass_number == 0 { CANDIDATES - 1 } else { CANDIDATES };
    for (&bits, &count) in fill.candidates.iter().zip(counts).take(searched) {
        if count > budget {
            fill.high_bits = fill.high_bits.min(bits);
        } else if bits >= fill.low_bits {
            (fill.low_bits, fill.low_count) = (bits, count);
        }
    }
    fill.high_bits = fill.high_bits.max(fill.low_bits);
    fill.pass_number += 1;
    let step = ((fill.high_bits - fill.low_bits) / (CANDIDATES as u32 + 1)).max(1);
    fill.candidates = std::array::from_fn(|c| (fill.low_bits + step * (c as u32 + 1)).min(fill.high_bits));
}
