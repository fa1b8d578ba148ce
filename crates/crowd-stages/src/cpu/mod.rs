//! The twins: each stage as a plain function over typed slices, following the paper.
//!
//! [`run_selection`] runs them in order up to the levels; [`run_frame`] goes on to the buffers of the draw.

mod admit_instances;
mod blend_palettes;
mod build_pyramid;
mod cell_boids;
mod cull_by_depth;
mod cull_instances;
mod fill_budget;
mod fill_cells;
mod find_leaders;
mod fit_budget;
mod gather_drawn;
mod hold_poses;
mod join_phases;
mod key_instances;
mod key_points;
mod key_poses;
mod lend_vertices;
mod place_boids;
mod place_buckets;
mod place_vertices;
mod play_motion;
mod pose_instance;
mod pose_points;
mod recall_seen;
mod reform_triangles;
mod scan_counts;
mod select_casters;
mod select_lod;
mod share_poses;
mod skin_vertices;
mod sort_at_once;
mod sort_instances;
mod steer_boids;
mod sum_weights;
mod test_occlusion;
mod write_bucket_args;
mod write_draw_args;

pub use admit_instances::admit_instances;
pub use blend_palettes::blend_palettes;
pub use build_pyramid::build_pyramid;
pub use cell_boids::cell_boids;
pub use cull_by_depth::{box_center, cull_by_depth};
pub use cull_instances::{FLOAT_BOUND, PLANE_BOUND_M, cull_instances, world_sphere};
pub use fill_budget::{FILL_PASSES, fill_budget};
pub use fill_cells::fill_cells;
pub use find_leaders::find_leaders;
pub use fit_budget::fit_budget;
pub use gather_drawn::{DRAWN_BOUND, gather_drawn};
pub use hold_poses::{
    HELD_BOUND_S, HOLD_LONGEST_S, HOLD_SHORTEST_S, HOLD_TICK_S, clip_speeds, held_tick, hold_poses, hold_ticks,
};
pub use join_phases::{begin_second, join_phases};
pub use key_instances::{FRACTION_BOUND, key_full_detail, key_instances};
pub use key_points::key_points;
pub use key_poses::key_poses;
pub use lend_vertices::{borrow_vertices, lend_vertices};
pub use place_boids::place_boids;
pub use place_buckets::place_buckets;
pub use place_vertices::place_vertices;
pub use play_motion::{SHARE_BOUND, TURNS_BOUND, play_motion};
pub use pose_instance::{FramePair, PosedInstance, frame_pair, pose_between, pose_instance};
pub use pose_points::{PosedPoint, pose_points};
pub use recall_seen::recall_seen;
pub use reform_triangles::{reform_level, reform_triangles, surviving};
pub use scan_counts::scan_counts;
pub use select_casters::select_casters;
pub use select_lod::{QUOTIENT_BOUND, select_lod};
pub use share_poses::{follow_leaders, range_leaders};
pub use skin_vertices::{SKIN_BOUND, skin_vertices};
pub use sort_at_once::sort_at_once;
pub use sort_instances::sort_instances;
pub use steer_boids::{STEER_BOUND, steer_boids};
pub use sum_weights::sum_weights;
pub use test_occlusion::{EDGE_BOUNDS, ScreenBox, is_hidden, screen_box, test_occlusion};
pub use write_bucket_args::write_bucket_args;
pub use write_draw_args::write_draw_args;

use crate::{
    Buckets, BudgetIn, Capacities, CrowdData, DrawArgs, Fit, FrameConfig, FrameTotals, InstanceBase, InstanceRecord,
    LodChoice, MorphRecord, Weight, WeightSums, discrete_config, overflow,
};
use crowd_pack::{CharacterRecord, LodRecord};
use glam::Vec3;

/// Everything one frame's stages produce.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CpuFrame {
    /// One per instance.
    pub choices: Vec<LodChoice>,
    /// One per instance where levels morph; else none.
    pub morphs: Vec<MorphRecord>,
    /// Sums.
    pub totals: FrameTotals,
    /// Bits of the water's height where the budget was filled: the next frame's [`FrameConfig::water_before_bits`].
    pub water_bits: u32,
}

/// The buffers of one frame's draw.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CpuBuffers {
    /// One per instance.
    pub bases: Vec<InstanceBase>,
    /// Whose vertex each entry of the vertex list is.
    pub slot_instances: Vec<u32>,
    /// Three a triangle, entries of the vertex list.
    pub indices: Vec<u32>,
    /// Of the draw.
    pub draw_args: DrawArgs,
}

/// Runs cull, weigh, select and fit for all instances: what to draw, at which level of `lods` (the data's, or those of
/// [`crate::Buckets::quantized_lods`]; for [`Weight::Error`] those of [`crate::Buckets::error_lods`]), the budget split as `fit` says.
///
/// `config.instance_count` is ignored; `instances` says it. No buffer can overflow here, so the only bit in the totals is
/// [`crate::overflow::BUDGET`]. About 3 ms for 30,000 instances on one core.
pub fn run_selection(
    data: &CrowdData,
    lods: &[LodRecord],
    instances: &[InstanceRecord],
    config: &FrameConfig,
    fit: Fit,
) -> CpuFrame {
    let unlimited = Capacities { vertex_count: u32::MAX, triangle_count: u32::MAX, ..Default::default() };
    let Choice { choices, bases, end, sums, water_bits } = select(data, lods, instances, config, fit);
    let (_, totals) = write_draw_args(&choices, &bases, end, &sums, &unlimited, config);
    CpuFrame { choices, totals, water_bits, ..Default::default() }
}

/// The same of quantised levels, which morph: what [`crate::Technique::Bucketed`] draws unless it is told not to.
///
/// `lods`: of [`Buckets::quantized_lods`].
pub fn run_morphing_selection(
    data: &CrowdData,
    buckets: &Buckets,
    lods: &[LodRecord],
    instances: &[InstanceRecord],
    config: &FrameConfig,
) -> CpuFrame {
    let frame = run_selection(data, lods, instances, config, Fit::Fill);
    let culled = cull_instances(data, instances, config);
    let mut sums = sum_weights(data, instances, &culled, config);
    let (choices, fill) = fill_budget(data, lods, instances, &culled, &mut sums, config);
    let config = FrameConfig { morph: 1, ..*config };
    let (_, morphs) = key_instances(buckets, instances, &culled, &choices, &fill, &config);
    CpuFrame { morphs, ..frame }
}

/// Runs all stages: the levels and the buffers of the draw, as far as `capacities` allow.
pub fn run_frame(
    data: &CrowdData,
    instances: &[InstanceRecord],
    config: &FrameConfig,
    capacities: &Capacities,
    fit: Fit,
) -> (CpuFrame, CpuBuffers) {
    let Choice { choices, bases, end, sums, water_bits } = select(data, &data.lods, instances, config, fit);
    let slot_instances = place_vertices(&choices, &bases, capacities);
    let indices = reform_triangles(data, instances, &choices, &bases, capacities);
    let (draw_args, totals) = write_draw_args(&choices, &bases, end, &sums, capacities, config);
    (
        CpuFrame { choices, totals, water_bits, ..Default::default() },
        CpuBuffers { bases, slot_instances, indices, draw_args },
    )
}

/// Levels, and what follows from them.
struct Choice {
    choices: Vec<LodChoice>,
    bases: Vec<InstanceBase>,
    end: InstanceBase,
    sums: WeightSums,
    water_bits: u32,
}

fn select(
    data: &CrowdData,
    lods: &[LodRecord],
    instances: &[InstanceRecord],
    config: &FrameConfig,
    fit: Fit,
) -> Choice {
    let culled = cull_instances(data, instances, config);
    // Eq. 1 as printed knows vertices alone.
    let budget_in = if fit == Fit::Fill { config.budget_in } else { BudgetIn::Vertices as u32 };
    let config = &FrameConfig { budget_in, ..*config };
    let mut sums = sum_weights(data, instances, &culled, config);
    let (choices, water_bits) = match fit {
        Fit::Fill => {
            let (choices, fill) = fill_budget(data, lods, instances, &culled, &mut sums, config);
            (choices, fill.smooth_bits)
        }
        Fit::Plain => {
            let wanted = select_lod(data, instances, &culled, &sums, config);
            (fit_budget(data, lods, instances, &wanted, &mut sums, config), 0)
        }
    };
    let (bases, end) = scan_counts(&choices);
    Choice { choices, bases, end, sums, water_bits }
}

/// Every instance at full detail, nothing culled: what [`crate::Technique::PseudoInstancing`] draws.
pub fn select_full_detail(data: &CrowdData, instances: &[InstanceRecord], config: &FrameConfig) -> CpuFrame {
    let mut totals = FrameTotals { visible_count: instances.len() as u32, ..Default::default() };
    let mut choices = Vec::with_capacity(instances.len());
    for one in instances {
        let CharacterRecord { vertex_count, triangle_count, min_vertex_count, .. } =
            data.characters[one.character as usize];
        choices.push(LodChoice { vertex_count, triangle_count });
        totals.vertex_count = totals.vertex_count.saturating_add(vertex_count);
        totals.triangle_count = totals.triangle_count.saturating_add(triangle_count);
        totals.min_vertex_count = totals.min_vertex_count.saturating_add(min_vertex_count);
    }
    (totals.needed_vertices, totals.needed_triangles) = (totals.vertex_count, totals.triangle_count);
    totals.overflow = if totals.min_vertex_count > config.budget { overflow::BUDGET } else { 0 };
    totals.draw_count = instances.len() as u32;
    CpuFrame { choices, totals, ..Default::default() }
}

/// What [`crate::Technique::Instanced`] draws: the visible instances at full detail.
pub fn select_visible(data: &CrowdData, instances: &[InstanceRecord], config: &FrameConfig) -> CpuFrame {
    let culled = cull_instances(data, instances, config);
    let level = |(instance, cull): (&InstanceRecord, &crate::CullRecord)| {
        let character = &data.characters[instance.character as usize];
        let (vertex_count, triangle_count) = (character.vertex_count, character.triangle_count);
        if cull.visible == 0 { LodChoice::default() } else { LodChoice { vertex_count, triangle_count } }
    };
    without_budget(instances.iter().zip(&culled).map(level).collect())
}

/// What [`crate::Technique::Discrete`] draws: three levels by depth.
pub fn select_discrete(
    data: &CrowdData,
    buckets: &Buckets,
    instances: &[InstanceRecord],
    config: &FrameConfig,
) -> CpuFrame {
    let discrete = discrete_config(&data.characters);
    let keys = cull_by_depth(data, buckets, &buckets.discrete_levels(), &discrete, instances, config);
    levels_of(buckets, &keys)
}

/// What [`crate::Technique::Points`] draws: points where they are dense enough, which have vertices and no triangles, and the others
/// at full detail. `buckets`: of [`Buckets::with_points`].
pub fn select_points(
    data: &CrowdData,
    buckets: &Buckets,
    instances: &[InstanceRecord],
    config: &FrameConfig,
) -> CpuFrame {
    let culled = cull_instances(data, instances, config);
    levels_of(buckets, &key_points(buckets, instances, &culled))
}

/// Levels that buckets stand for, without a budget.
fn levels_of(buckets: &Buckets, keys: &[u32]) -> CpuFrame {
    let level = |key: &u32| {
        let record = buckets.records.get(*key as usize).copied().unwrap_or_default();
        LodChoice { vertex_count: record.vertex_count, triangle_count: record.triangle_count }
    };
    without_budget(keys.iter().map(level).collect())
}

/// Levels that no budget chose, and their sums.
fn without_budget(choices: Vec<LodChoice>) -> CpuFrame {
    let (_, end) = scan_counts(&choices);
    let totals = FrameTotals {
        visible_count: choices.iter().filter(|choice| choice.vertex_count > 0).count() as u32,
        outside_count: choices.iter().filter(|choice| choice.vertex_count == 0).count() as u32,
        vertex_count: end.vertex_base,
        triangle_count: end.triangle_base,
        needed_vertices: end.vertex_base,
        needed_triangles: end.triangle_base,
        ..Default::default()
    };
    CpuFrame { choices, totals, ..Default::default() }
}

/// One over the height of the water, where that is pixels.
fn threshold_px(sums: &WeightSums, config: &FrameConfig) -> f32 {
    let is_error = config.weight == Weight::Error as u32;
    if is_error { 1.0 / f32::from_bits(sums.water_bits).max(1e-30) } else { 0.0 }
}

/// Whether an instance's part ends inside both buffers. Ends never decrease, so the kept instances are the first ones.
fn is_kept(base: InstanceBase, choice: LodChoice, capacities: &Capacities) -> bool {
    base.vertex_base.saturating_add(choice.vertex_count) <= capacities.vertex_count
        && base.triangle_base.saturating_add(choice.triangle_count) <= capacities.triangle_count
}

/// Turns by a yaw: 0 faces +Z, positive turns towards +X.
fn turn(yaw_rad: f32, v: Vec3) -> Vec3 {
    let (s, c) = libm::sincosf(yaw_rad);
    Vec3::new(c * v.x + s * v.z, v.y, c * v.z - s * v.x)
}

fn world_from_local(instance: &InstanceRecord, p: Vec3) -> Vec3 {
    Vec3::from_array(instance.position) + turn(instance.yaw_rad, p * instance.scale)
}
