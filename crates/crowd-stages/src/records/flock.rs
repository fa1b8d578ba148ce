//! A flock that is simulated on the GPU, and instances that a simulator hands over.

use bytemuck::{Pod, Zeroable};

/// Rules of a flock and the grid by which neighbours are found, a uniform of 112 bytes. Metres, seconds, metres a second.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct FlockConfig {
    /// How many there are.
    pub boid_count: u32,
    /// Cells along X.
    pub columns: u32,
    /// Cells along Z.
    pub rows: u32,
    /// Nobody follows more neighbours than this: the own cell's first, in order of number.
    pub most_followed: u32,
    /// Least corner of the grid, X and Z. Whoever is outside counts as in the outermost cells.
    pub low: [f32; 2],
    /// Slowest and fastest.
    pub speed_m_s: [f32; 2],
    /// Weight of keeping apart from those within `apart_m`.
    pub separation: f32,
    /// Weight of taking on the neighbours' mean velocity.
    pub alignment: f32,
    /// Weight of going towards the neighbours' middle.
    pub cohesion: f32,
    /// Comfortable distance between two people; wider bodies have theirs besides ([`BoidRecord::wider_m`]).
    pub apart_m: f32,
    /// Who is nearer is a neighbour; the side of a cell. At least what the two widest keep apart.
    pub sight_m: f32,
    /// Radius of the round place around the origin.
    pub radius_m: f32,
    /// They turn back from this share of it on.
    pub rim: f32,
    /// Whose distance is less is pushed away; wider bodies have theirs besides.
    pub bodies_m: f32,
    /// By at most this in a step.
    pub most_push_m: f32,
    /// Acceleration at most, m/s².
    pub most_m_s2: f32,
    /// Facing follows the velocity by this share a second.
    pub turn_hz: f32,
    /// Length of a step.
    pub step_s: f32,
    /// Standing begins below the first and ends at the second.
    pub stands_below_m_s: [f32; 2],
    /// Running ends below the first and begins at the second.
    pub runs_from_m_s: [f32; 2],
    /// Time shown: clips play at `time_s` plus an instance's phase.
    pub time_s: f32,
    /// Clips slower over the ground than this play at their own rate.
    pub least_clip_speed_m_s: f32,
    /// Nobody's gait changes sooner than this after the last change.
    pub shortest_gait_s: f32,
    /// Time over which someone fades from one gait into the next, at most that; 0: at once.
    pub fade_s: f32,
}

/// One of a flock, 48 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct BoidRecord {
    /// X and Z, metres.
    pub place: [f32; 2],
    /// The same a second.
    pub velocity: [f32; 2],
    /// Facing: 0 looks along +Z.
    pub yaw_rad: f32,
    /// Metres walked since the start.
    pub walked_m: f32,
    /// The speed this one likes.
    pub pace_m_s: f32,
    /// 0 stands, 1 walks, 2 runs: an index into [`MoverRecord::clips`].
    pub gait: u32,
    /// The gait before this one.
    pub gait_before: u32,
    /// Metres run, part of those walked.
    pub ran_m: f32,
    /// Seconds since the gait changed; many where it never did.
    pub changed_s: f32,
    /// Metres that its body's radius is beyond a person's, half of [`FlockConfig::bodies_m`]; not below 0.
    pub wider_m: f32,
}

/// What neighbours need to know of a boid, 24 bytes; those of a cell lie side by side.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct SortedBoid {
    /// X and Z, metres.
    pub place: [f32; 2],
    /// The same a second.
    pub velocity: [f32; 2],
    /// [`BoidRecord::wider_m`].
    pub wider_m: f32,
    /// Zero.
    pub reserved: u32,
}

/// What stays the same of a boid, 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct BoidTraits {
    /// Index of its [`MoverRecord`].
    pub mover: u32,
    /// Size, besides the mover's.
    pub scale: f32,
    /// Where in its clips it begins, 0 to below 1.
    pub start: f32,
    /// Zero.
    pub reserved: u32,
}

/// A clip as those who walk use it, 288 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct GaitClipRecord {
    /// What the clip itself moves the character by in one turn, metres at scale 1.
    pub displacement_m: [f32; 3],
    /// Seconds; 0 for a single pose.
    pub duration_s: f32,
    /// Speed over the ground at which the feet do not slide, at scale 1; 0 where it is not known.
    pub ground_speed_m_s: f32,
    /// Index in the crowd's clip table.
    pub clip: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
    /// Where the character has to be beside its even way for standing feet to stay: x and z, metres at scale 1, evenly spread over a
    /// turn; the first comes again after the last.
    pub root_path_m: [[f32; 2]; ROOT_PATH_POINTS],
}

/// Points of a clip's root path.
pub const ROOT_PATH_POINTS: usize = 32;

/// A character as one of a flock, 880 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MoverRecord {
    /// For standing, walking and running.
    pub clips: [GaitClipRecord; 3],
    /// Index of the character.
    pub character: u32,
    /// Factor between the character's own metres and those of the world.
    pub scale: f32,
    /// Turns that the run clip is ahead of the walk clip where its feet are where the walk's are.
    pub run_ahead_turns: f32,
    /// Zero.
    pub reserved: u32,
}

/// What is known of instances that a simulator hands over, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct FeedConfig {
    /// Instances that may be taken.
    pub most: u32,
    /// Characters there are.
    pub character_count: u32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
}

/// What was taken of them, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct FeedState {
    /// Instances of the frame: the simulator's count, at most [`FeedConfig::most`].
    pub count: u32,
    /// Of the simulator's count those that are not drawn: past the end, with a character or clip that is not there, or a number
    /// that is not finite.
    pub refused_count: u32,
}
