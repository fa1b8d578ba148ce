//! Where the people stand: layouts and camera paths. Later: layout files and simulator feeds.

use glam::{Mat4, Vec3};

/// One individual in the crowd.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Feet, metres.
    pub position: Vec3,
    /// Facing: 0 looks along +Z, positive turns towards +X.
    pub yaw_rad: f32,
    /// Size factor.
    pub scale: f32,
    /// Index of the character.
    pub character: u32,
    /// Index of the clip within its character.
    pub clip: u32,
    /// Start time within the clip, seconds.
    pub phase_s: f32,
}

/// What a layout needs to know of a character.
#[derive(Debug, Clone, PartialEq)]
pub struct Kind {
    /// Radius on the ground, metres, for spacing.
    pub footprint_m: f32,
    /// Durations of its clips, seconds; at least one.
    pub clip_durations_s: Vec<f32>,
}

/// Places and ways of standing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layout {
    /// Rows and columns around the origin, slightly shuffled.
    Grid,
    /// A sunflower spiral around the origin: even density, no rows.
    Disc,
    /// Straight ranks, everyone facing +Z, nothing shuffled: for comparing pictures.
    Ranks,
    /// A street along Z: two opposing streams.
    Street,
}

/// Camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position, metres.
    pub eye: Vec3,
    /// Looked at, metres.
    pub target: Vec3,
    /// Vertical field of view.
    pub fov_y_rad: f32,
    /// Near plane, metres.
    pub near_m: f32,
    /// Far plane, metres.
    pub far_m: f32,
}

impl Camera {
    /// World to clip space, depth 0 to 1, Y up (wgpu's convention).
    pub fn clip_from_world(&self, aspect: f32) -> Mat4 {
        let _ = aspect;
        unimplemented!("crowd-scene: being written")
    }
}

/// Places `count` instances. `clips`: which clips may play (names resolved by the caller, per kind); empty means all.
/// Character, clip and phase come from a hash of the instance's number and `seed`: the same crowd every time.
pub fn place(
    layout: Layout,
    count: u32,
    spacing_m: f32,
    kinds: &[Kind],
    clips: &[Vec<u32>],
    seed: u32,
) -> Vec<Instance> {
    let _ = (layout, count, spacing_m, kinds, clips, seed);
    unimplemented!("crowd-scene: being written")
}
