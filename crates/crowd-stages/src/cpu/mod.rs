//! The twins: each stage as a plain function over typed slices, following the paper.

use crate::{CrowdData, FrameConfig, FrameTotals, InstanceRecord, LodChoice};

/// Everything one frame's stages produce.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CpuFrame {
    /// One per instance.
    pub choices: Vec<LodChoice>,
    /// Sums.
    pub totals: FrameTotals,
}

/// Runs cull, weigh, select and fit for all instances: what to draw, at which level.
pub fn run_selection(data: &CrowdData, instances: &[InstanceRecord], config: &FrameConfig) -> CpuFrame {
    let _ = (data, instances, config);
    unimplemented!("crowd-stages: being written")
}

/// An instance posed on the CPU at its level: what the vertex shader computes, vertex by vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PosedInstance {
    /// World positions of the level's vertices.
    pub positions: Vec<[f32; 3]>,
    /// World normals, unit.
    pub normals: Vec<[f32; 3]>,
    /// Reformed triangles, indices below the level's vertex count.
    pub triangles: Vec<[u32; 3]>,
}

/// Poses one instance at the level chosen, at `time_s`.
pub fn pose_instance(data: &CrowdData, instance: &InstanceRecord, choice: LodChoice, time_s: f32) -> PosedInstance {
    let _ = (data, instance, choice, time_s);
    unimplemented!("crowd-stages: being written")
}
