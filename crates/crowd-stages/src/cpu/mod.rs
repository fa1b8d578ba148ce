//! The twins: each stage as a plain function over typed slices, following the paper.
//!
//! [`run_selection`] runs them in order up to the levels; [`run_frame`] goes on to the buffers of the draw.

mod cull_instances;
mod fit_budget;
mod place_vertices;
mod pose_instance;
mod reform_triangles;
mod scan_counts;
mod select_lod;
mod sum_weights;
mod write_draw_args;

pub use cull_instances::{FLOAT_BOUND, PLANE_BOUND_M, cull_instances, world_sphere};
pub use fit_budget::fit_budget;
pub use place_vertices::place_vertices;
pub use pose_instance::{FramePair, PosedInstance, frame_pair, pose_instance};
pub use reform_triangles::{reform_level, reform_triangles};
pub use scan_counts::scan_counts;
pub use select_lod::{QUOTIENT_BOUND, select_lod};
pub use sum_weights::sum_weights;
pub use write_draw_args::write_draw_args;

use crate::{Capacities, CrowdData, DrawArgs, FrameConfig, FrameTotals, InstanceBase, InstanceRecord, LodChoice};
use glam::Vec3;

/// Everything one frame's stages produce.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CpuFrame {
    /// One per instance.
    pub choices: Vec<LodChoice>,
    /// Sums.
    pub totals: FrameTotals,
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

/// Runs cull, weigh, select and fit for all instances: what to draw, at which level.
///
/// `config.instance_count` is ignored; `instances` says it. No buffer can overflow here, so the only bit in the totals is
/// [`crate::overflow::BUDGET`]. About 3 ms for 30,000 instances on one core.
pub fn run_selection(data: &CrowdData, instances: &[InstanceRecord], config: &FrameConfig) -> CpuFrame {
    let unlimited = Capacities { vertex_count: u32::MAX, triangle_count: u32::MAX, ..Default::default() };
    let (choices, bases, end, sums) = select(data, instances, config);
    let (_, totals) = write_draw_args(&choices, &bases, end, &sums, &unlimited, config);
    CpuFrame { choices, totals }
}

/// Runs all stages: the levels and the buffers of the draw, as far as `capacities` allow.
pub fn run_frame(
    data: &CrowdData,
    instances: &[InstanceRecord],
    config: &FrameConfig,
    capacities: &Capacities,
) -> (CpuFrame, CpuBuffers) {
    let (choices, bases, end, sums) = select(data, instances, config);
    let slot_instances = place_vertices(&choices, &bases, capacities);
    let indices = reform_triangles(data, instances, &choices, &bases, capacities);
    let (draw_args, totals) = write_draw_args(&choices, &bases, end, &sums, capacities, config);
    (CpuFrame { choices, totals }, CpuBuffers { bases, slot_instances, indices, draw_args })
}

fn select(
    data: &CrowdData,
    instances: &[InstanceRecord],
    config: &FrameConfig,
) -> (Vec<LodChoice>, Vec<InstanceBase>, InstanceBase, crate::WeightSums) {
    let culled = cull_instances(data, instances, config);
    let mut sums = sum_weights(data, instances, &culled);
    let wanted = select_lod(data, instances, &culled, &sums, config);
    let choices = fit_budget(data, instances, &wanted, &mut sums, config);
    let (bases, end) = scan_counts(&choices);
    (choices, bases, end, sums)
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
