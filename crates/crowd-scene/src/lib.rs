//! Where the people stand, how they walk, and who looks at them: layouts, trajectories, cameras, and the files of all.
//!
//! Knows nothing of meshes or of the GPU: a character is an index, a footprint and the durations of its clips. Everything
//! is deterministic (integer hashes, `libm`): the same arguments place the same crowd on every machine.

mod area;
mod camera;
mod camera_path;
mod dice;
mod error;
mod layout_file;
mod place;
mod sqlite;
mod text;
mod trajectory;
mod walker;

pub use area::{Surface, WalkableArea};
pub use camera::{frame_crowd, framing_crowd, overlook};
pub use camera_path::{CameraKey, CameraPath};
pub use error::{Error, Result};
pub use layout_file::{parse_layout, write_layout};
pub use place::place;
pub use trajectory::Trajectories;
pub use walker::{Cast, Gait, GaitClip, Mover, Walker};

use glam::Vec3;

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
