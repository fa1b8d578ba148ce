//! Maps of what the sun sees.

use crate::dispatch;
use bytemuck::{Pod, Zeroable};

/// A shadow map of the sun, 80 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct Cascade {
    /// World to the map: x and y -1 to 1, z 0 nearest to the sun, columns.
    pub clip_from_world: [[f32; 4]; 4],
    /// Side of a texel, metres.
    pub texel_m: f32,
    /// Half of the map's side, metres.
    pub half_m: f32,
    /// One over the error, metres, that its casters may have.
    pub details_per_m: f32,
    /// How much deeper in the map a point is that lies a metre farther from the sun.
    pub depth_per_m: f32,
}

/// The sun's shadow maps, a uniform of 336 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct ShadowConfig {
    /// The finest first.
    pub cascades: [Cascade; dispatch::MAX_CASCADES as usize],
    /// How many there are.
    pub cascade_count: u32,
    /// Height that no shadow falls below, metres.
    pub floor_m: f32,
    /// Texels a side of each map.
    pub side: u32,
    /// Zero.
    pub reserved: u32,
}

/// Whose casters `select_casters` selects, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct CascadeStep {
    /// Number of the cascade.
    pub cascade: u32,
    /// 1 where the levels that the camera sees are known.
    pub has_choices: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
}
