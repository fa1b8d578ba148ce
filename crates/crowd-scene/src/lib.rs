//! Where the people stand, how they walk, and who looks at them: layouts, trajectories, cameras, and the files of all.
//!
//! Knows nothing of meshes or of the GPU: a character is an index, a footprint and the durations of its clips. Everything
//! is deterministic (integer hashes, `libm`): the same arguments place the same crowd on every machine.

mod area;
mod camera;
mod camera_path;
mod camera_ways;
mod dice;
mod error;
mod flock;
mod layout_file;
mod motion_graph;
mod motion_schedule;
mod place;
mod sqlite;
mod text;
mod trajectory;
mod walker;
mod waypoints;

pub use area::{Surface, WalkableArea};
pub use camera::{frame_crowd, framing_crowd, overlook};
pub use camera_path::{CameraKey, CameraPath};
pub use error::{Error, Result};
pub use flock::{Boid, FLOCK_LOOP_S, FLOCK_STEP_S, Flock, FlockGrid, FlockRules};
pub use layout_file::{parse_layout, write_layout};
pub use motion_graph::{MotionGraph, MotionState, MotionWay, Stay, UsualClip};
pub use motion_schedule::{MotionStretch, Schedule, StateClip, deal_schedule};
pub use place::{place, seat_steps, spacing_used};
pub use trajectory::Trajectories;
pub use walker::{Cast, Gait, GaitClip, LEAST_CLIP_SPEED_M_S, Mover, RootPath, Walker, WalkerTraits};
pub use waypoints::Waypoints;

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
    /// The clip it comes from, while it fades.
    pub leaving: Leaving,
}

/// A clip that someone fades out of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Leaving {
    /// Index of the clip within the character.
    pub clip: u32,
    /// Start time within it, seconds.
    pub phase_s: f32,
    /// Its share of the pose, 0 to 1; 0: nobody fades.
    pub share: f32,
}

/// What a layout needs to know of a character.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Kind {
    /// For layout files; may be empty.
    pub name: String,
    /// Of its clips, in order, for layout files; may be empty.
    pub clip_names: Vec<String>,
    /// Radius on the ground, metres, for spacing.
    pub footprint_m: f32,
    /// Durations of its clips, seconds; at least one.
    pub clip_durations_s: Vec<f32>,
}

/// A ring of ground that seats stand on, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeatStep {
    /// Radius of its inner edge.
    pub inner_m: f32,
    /// Radius of its outer edge.
    pub outer_m: f32,
    /// Above the ground.
    pub height_m: f32,
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
    /// Rings of seats around a stage, each higher than the one before it, everyone facing the middle.
    Seats,
}

/// Every layout and its name, in files and on the command line.
const LAYOUTS: [(&str, Layout); 5] = [
    ("grid", Layout::Grid),
    ("disc", Layout::Disc),
    ("ranks", Layout::Ranks),
    ("street", Layout::Street),
    ("seats", Layout::Seats),
];

impl Layout {
    /// The layout of that name.
    pub fn named(name: &str) -> Option<Self> {
        LAYOUTS.iter().find(|(known, _)| *known == name).map(|&(_, layout)| layout)
    }

    /// All names, as a sentence has them.
    pub fn names() -> String {
        let names: Vec<&str> = LAYOUTS.iter().map(|(name, _)| *name).collect();
        format!("{} or {}", names[..names.len() - 1].join(", "), names[names.len() - 1])
    }
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
