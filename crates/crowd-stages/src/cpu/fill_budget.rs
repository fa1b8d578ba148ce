//! The budget is spent: water rises over the crowd until its vertices, or its triangles, are N.

use crate::dispatch::{ERROR_ENTRIES, ERROR_FIRST_BITS, ERROR_SHIFT, FILL_CANDIDATES};
use crate::impostors::{impostor_level, least_count};
use crate::{BudgetIn, CrowdData, CullRecord, FillState, FrameConfig, InstanceRecord, LodChoice, Weight, WeightSums};
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
/// With [`crate::BudgetIn::Triangles`] the levels' triangles count, not their vertices; levels rise by vertices all the same.
///
/// With `config.slack` the water stays where it was in the frame before (`water_before_bits`) as long as what it comes to is between
/// N less the slack and N; where it must rise or fall, it goes to the nearer edge and an eighth of the slack beyond, and stays there in the next frame. So levels change by
/// what the camera changes, not by who comes and leaves.
///
/// With [`Weight::Error`] the weight is the pixels that a metre takes and the water one over pixels: every instance gets the
/// coarsest quantised level whose bound is at most `1 / (weight * water)` metres, from the error tables. So one threshold in
/// pixels holds for all, the smallest that the budget allows (but for full detail, which has no better).
///
/// Whoever is below `config.impostor_area_px2` is their impostor, whatever the water, and takes no more of the budget.
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
        if let Some(level) = impostor_level(character, culled[i].area_px2, product, config) {
            return level;
        }
        let least = least_count(character, culled[i].area_px2, config);
        let k = product.min(character.vertex_count as f32).max(least as f32);
        lods[(character.lod_offset + k as u32) as usize]
    };
    let visible: Vec<usize> = (0..instances.len()).filter(|i| culled[*i].visible != 0).collect();
    let spent = |lod: LodRecord| config.spent(lod.vertex_count, lod.triangle_count);
    let sum = |bits: u32| visible.iter().fold(0u32, |sum, i| sum.saturating_add(spent(level(*i, bits))));

    let mut fill = begin(sums, config);
    for pass in 0..FILL_PASSES {
        let counts = fill.candidates.map(sum);
        if pass == 0 {
            let has_plain = config.weight != Weight::Error as u32 && config.budget_in == BudgetIn::Vertices as u32;
            sums.wanted_count = if has_plain { counts[CANDIDATES - 1] } else { 0 };
        }
        narrow(&mut fill, &counts, config);
        sums.water_bits = fill.low_bits;
    }

    let mut choices = vec![LodChoice::default(); instances.len()];
    let left = fill.goal.saturating_sub(fill.low_count);
    let mut taken = 0u32;
    for i in visible {
        let (low, high) = (level(i, fill.low_bits), level(i, fill.high_bits));
        taken = taken.saturating_add(spent(high).saturating_sub(spent(low)));
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

/// Whether the water may stay where it was.
fn has_before(config: &FrameConfig) -> bool {
    config.slack > 0 && config.water_before_bits > 0
}

/// The first candidates: powers of two around Eq. 1's height, then the highest, and last Eq. 1's own. Where the water may stay, its
/// height before comes first.
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
    if has_before(config) {
        candidates[0] = config.water_before_bits.min(HIGHEST_BITS);
    }
    let low_count = sums.min_vertex_count;
    let (high_bits, high_count, goal) = (HIGHEST_BITS, u32::MAX, config.budget);
    FillState { high_bits, high_count, low_count, candidates, goal, ..Default::default() }
}

/// As far between the two heights as the goal is between their counts.
fn smooth_bits(fill: &FillState) -> u32 {
    let left = fill.goal.saturating_sub(fill.low_count) as f32;
    let part = (left / fill.high_count.saturating_sub(fill.low_count).max(1) as f32).min(1.0);
    fill.low_bits + ((fill.high_bits - fill.low_bits) as f32 * part) as u32
}

/// Between which candidates the budget lies, and the next ones, evenly between those two.
fn narrow(fill: &mut FillState, counts: &[u32; CANDIDATES], config: &FrameConfig) {
    let least = config.budget.saturating_sub(config.slack);
    if fill.pass_number == 0 && has_before(config) {
        if (least..=config.budget).contains(&counts[0]) {
            let (bits, count) = (fill.candidates[0], counts[0]);
            // Nothing is left to search between equal heights.
            let (low_bits, high_bits, smooth_bits) = (bits, bits, bits);
            let (low_count, high_count, pass_number) = (count, count, 1);
            let candidates = [bits; CANDIDATES];
            *fill =
                FillState { low_bits, high_bits, smooth_bits, low_count, high_count, pass_number, candidates, ..*fill };
            return;
        }
        // A little beyond the edge: there it may stay in the next frame, though levels come to something else than the search thought.
        let beyond = (config.budget - least) / 8;
        fill.goal = if counts[0] < least { least + beyond } else { config.budget - beyond };
    }
    let searched = if fill.pass_number == 0 { CANDIDATES - 1 } else { CANDIDATES };
    for (&bits, &count) in fill.candidates.iter().zip(counts).take(searched) {
        if count > fill.goal {
            if bits <= fill.high_bits {
                (fill.high_bits, fill.high_count) = (bits, count);
            }
        } else if bits >= fill.low_bits {
            (fill.low_bits, fill.low_count) = (bits, count);
        }
    }
    fill.high_bits = fill.high_bits.max(fill.low_bits);
    fill.smooth_bits = smooth_bits(fill);
    fill.pass_number += 1;
    let step = ((fill.high_bits - fill.low_bits) / (CANDIDATES as u32 + 1)).max(1);
    fill.candidates = std::array::from_fn(|c| (fill.low_bits + step * (c as u32 + 1)).min(fill.high_bits));
}
