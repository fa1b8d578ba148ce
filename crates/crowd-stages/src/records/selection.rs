//! Who is seen, and at which level.

use crate::dispatch;
use bytemuck::{Pod, Zeroable};

/// One individual, 48 bytes.
///
/// It plays one clip, or fades from one to another: matrices of both are blended by `leaving_share`. Bytes of zeros after
/// `phase_s` are someone who does not fade.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct InstanceRecord {
    /// Feet, metres.
    pub position: [f32; 3],
    /// 0 faces +Z; positive turns towards +X.
    pub yaw_rad: f32,
    /// Size factor.
    pub scale: f32,
    /// Index into the character records.
    pub character: u32,
    /// Index into the clip records (global).
    pub clip: u32,
    /// Start time within the clip, seconds.
    pub phase_s: f32,
    /// The clip it leaves (global), of the same character; means nothing while `leaving_share` is 0.
    pub leaving_clip: u32,
    /// Start time within that clip, seconds.
    pub leaving_phase_s: f32,
    /// Share of the clip it leaves, 0 to 1; 0: it plays one clip alone.
    pub leaving_share: f32,
    /// How long ago its pose is of, seconds: both clips are shown as they were then.
    pub held_s: f32,
}

impl InstanceRecord {
    /// The clip it leaves, or the one it plays where it leaves none.
    pub fn left_clip(&self) -> u32 {
        if self.leaving_share > 0.0 { self.leaving_clip } else { self.clip }
    }
}

/// Result of `cull_instances`, 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct CullRecord {
    /// One more than the number of its character when the bounding sphere meets the frustum: later stages go without the instance. 0: not seen.
    pub visible: u32,
    /// The instance's weight; 0 when culled.
    pub weight: f32,
    /// Projected area of the bounding sphere, px².
    pub area_px2: f32,
    /// Distance of the sphere's centre to the camera, metres.
    pub distance_m: f32,
}

/// Result of `select_lod` and `fit_budget`, 8 bytes. Zeros when culled.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct LodChoice {
    /// Vertices: k.
    pub vertex_count: u32,
    /// Triangles: q(k).
    pub triangle_count: u32,
}

/// Result of `sum_weights`, completed by `fit_budget`, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct WeightSums {
    /// Sum of the weights: the denominator of Eq. 1.
    pub weight: f32,
    /// Vertices (or what the budget counts) of the visible instances' coarsest levels, saturating.
    pub min_vertex_count: u32,
    /// Visible instances.
    pub visible_count: u32,
    /// Vertices that Eq. 1 as printed comes to, saturating.
    pub wanted_count: u32,
    /// Share of what was wanted above the coarsest levels that the budget allows, in units of 2^-32.
    /// Meaningful only when `is_scaled` is 1.
    pub share: u32,
    /// 1 when what was wanted exceeds the budget.
    pub is_scaled: u32,
    /// Bits of the water's height that `fill_budget` found, vertices a unit of weight; [`crate::Weight::Error`]: one over pixels.
    pub water_bits: u32,
    /// Zero.
    pub reserved: u32,
}

/// Where the search of `fill_budget` has got to, 176 bytes. Heights are bits of floats, vertices a unit of weight.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct FillState {
    /// Greatest height known to fit.
    pub low_bits: u32,
    /// Least height known not to fit, or the same.
    pub high_bits: u32,
    /// Vertices (or what the budget counts) at the former.
    pub low_count: u32,
    /// Passes done, or rounds.
    pub pass_number: u32,
    /// Heights to try next, rising; in the first pass the last is that of Eq. 1. On the GPU those of the first pass, none before them.
    pub candidates: [u32; dispatch::FILL_CANDIDATES as usize],
    /// What the levels may come to: the budget, or less by the slack.
    pub goal: u32,
    /// Vertices (or what the budget counts) at `high_bits`, saturating.
    pub high_count: u32,
    /// Between the two heights, as far as the goal is between their counts: what morphs go by.
    pub smooth_bits: u32,
    /// The chunk of instances in which the budget runs out. This and what follows is the GPU's own; zero in the twin.
    pub edge: u32,
    /// The heights that the search may end at are numbered as they rise: number of the greatest known to fit.
    pub low_cell: u32,
    /// Of the least known not to fit, or one more than there are.
    pub high_cell: u32,
    /// Which of all heights tried the two are.
    pub low_slot: u32,
    /// See `low_slot`.
    pub high_slot: u32,
    /// Those to try next; `u32::MAX` for heights that are not of the search.
    pub cells: [u32; dispatch::FILL_TRIED as usize],
    /// Their bits.
    pub heights: [u32; dispatch::FILL_TRIED as usize],
}

/// What [`crate::Technique::Discrete`] is told of the crowd, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct DiscreteConfig {
    /// Half the diagonal of the largest character's box, metres.
    pub half_diagonal_m: f32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
    /// Zero.
    pub reserved_c: u32,
}
