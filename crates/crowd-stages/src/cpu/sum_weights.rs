//! The denominator of Eq. 1, and what the coarsest crowd would cost.

use crate::dispatch::BLOCK_SIZE;
use crate::impostors::least_spent;
use crate::{CrowdData, CullRecord, FrameConfig, InstanceRecord, WeightSums};

/// Adds up weights, vertex counts of the coarsest levels (dots and impostors, where `config` allows them; triangles, where the budget counts those)
/// and visible instances.
///
/// `culled`: one per instance. The result's `wanted_count`, `share` and `is_scaled` are 0; `fit_budget` fills them in.
///
/// Paper: the sum in Peng 2011 Eq. 1. Departs: the papers do not say how they sum; floats are added here in the order of the
/// GPU's tree (blocks of 256, halves onto halves), which is also more exact than one after the other.
///
/// Twin: `shaders/stages/sum_weights.wgsl`. Equal for equal weights.
pub fn sum_weights(
    data: &CrowdData,
    instances: &[InstanceRecord],
    culled: &[CullRecord],
    config: &FrameConfig,
) -> WeightSums {
    let mut weights: Vec<f32> = Vec::with_capacity(culled.len());
    let mut sums = WeightSums::default();
    for (instance, cull) in instances.iter().zip(culled) {
        let visible = cull.visible != 0;
        weights.push(if visible { cull.weight } else { 0.0 });
        if visible {
            let character = &data.characters[instance.character as usize];
            let least = least_spent(character, cull.area_px2, config);
            sums.min_vertex_count = sums.min_vertex_count.saturating_add(least);
            sums.visible_count += 1;
        }
    }
    sums.weight = tree_sum(&weights);
    sums
}

/// Blocks by a tree; then 256 runs of blocks, one by one; then the runs by a tree.
fn tree_sum(values: &[f32]) -> f32 {
    let blocks: Vec<f32> = values.chunks(BLOCK_SIZE as usize).map(halve_until_one).collect();
    let run = blocks.len().div_ceil(BLOCK_SIZE as usize).max(1);
    let threads: Vec<f32> = blocks.chunks(run).map(|run| run.iter().fold(0.0, |sum, block| sum + block)).collect();
    halve_until_one(&threads)
}

fn halve_until_one(values: &[f32]) -> f32 {
    let mut lanes = [0.0f32; BLOCK_SIZE as usize];
    lanes[..values.len()].copy_from_slice(values);
    let mut half = lanes.len() / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] += lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}
