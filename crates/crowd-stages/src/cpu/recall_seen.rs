//! Who was hidden waits, and a little of the budget is kept for those who come into sight.

use crate::dispatch::{AT_ONCE_GROUP_SIZE, AT_ONCE_RUNS, AT_ONCE_SHORTEST, BLOCK_SIZE, FOLD_COLUMNS, RESERVE_PART};
use crate::impostors::least_spent;
use crate::{CrowdData, CullRecord, FrameConfig, InstanceRecord, SightTally, sight};

/// Takes those whom the last frame's depth hid out of the visible ones, and gives the budget of the first phase.
///
/// `seen`: the number of instances it is valid for, then a word of [`sight`] for each, as `test_occlusion` left it; of another
/// number it says nothing, and everyone counts as seen. `culled`: one per instance; who waits is no longer visible but keeps
/// its weight, which who is outside has not. Returns the tally and the frame's config with the budget lowered by what the
/// waiting need at their coarsest, at most a `RESERVE_PART`th: so newcomers find room and the frame keeps its budget. Its slack is lowered by as much: both
/// together leave no more over than the larger of the two.
///
/// The gate of the second phase comes third: arguments of its dispatches that go by blocks of instances, of those of one group, and of the sort in one
/// pass; zeros where nobody waits, so that they do nothing.
///
/// Paper: two-phase occlusion culling after Haar & Aaltonen 2015 ("GPU-driven rendering pipelines"); the budget's part is ours.
/// Twin: `shaders/stages/recall_seen.wgsl`. Equal.
pub fn recall_seen(
    data: &CrowdData,
    instances: &[InstanceRecord],
    seen: &[u32],
    culled: &mut [CullRecord],
    config: &FrameConfig,
) -> (SightTally, FrameConfig, [[u32; 3]; 3]) {
    let mut tally = SightTally::default();
    if seen[0] == instances.len() as u32 {
        for ((instance, cull), word) in instances.iter().zip(culled).zip(&seen[1..]) {
            if cull.visible != 0 && word & sight::HIDDEN != 0 {
                cull.visible = 0;
                let character = &data.characters[instance.character as usize];
                let least = least_spent(character, cull.area_px2, config);
                tally.hidden_min_count = tally.hidden_min_count.saturating_add(least);
                tally.hidden_count += 1;
            }
        }
    }
    let kept = tally.hidden_min_count.min(config.budget / RESERVE_PART);
    // What is kept is part of what may be left.
    let slack = config.slack.saturating_sub(kept);
    let gate = gate_of(if tally.hidden_count > 0 { instances.len() as u32 } else { 0 });
    (tally, FrameConfig { budget: config.budget - kept, slack, ..*config }, gate)
}

fn gate_of(count: u32) -> [[u32; 3]; 3] {
    let runs = count.div_ceil(count.div_ceil(AT_ONCE_RUNS).max(AT_ONCE_SHORTEST));
    [count.div_ceil(BLOCK_SIZE), count.min(1), runs.div_ceil(AT_ONCE_GROUP_SIZE)]
        .map(|groups| [groups.min(FOLD_COLUMNS), groups.div_ceil(FOLD_COLUMNS), groups.min(1)])
}
