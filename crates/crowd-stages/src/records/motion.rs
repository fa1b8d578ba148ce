//! What instances play from second to second.

use bytemuck::{Pod, Zeroable};

/// A clip that is played and, in its first seconds, the one that is left for it, 48 bytes. Turns count from a clip's beginning.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MotionStretch {
    /// From the schedule's beginning, seconds.
    pub start_s: f32,
    /// Seconds of the fade at its beginning; the next stretch does not begin before its end.
    pub fade_s: f32,
    /// Index into the clip records (global).
    pub clip: u32,
    /// Turns at the beginning.
    pub turns: f32,
    /// Turns a second at the beginning, from which they go evenly to `rate_hz` at the fade's end.
    pub first_rate_hz: f32,
    /// Turns a second after the fade.
    pub rate_hz: f32,
    /// The clip that is left (global), of the same character.
    pub left_clip: u32,
    /// Its turns at the beginning.
    pub left_turns: f32,
    /// Its turns a second at the beginning.
    pub left_rate_hz: f32,
    /// Its turns a second at the fade's end.
    pub left_last_rate_hz: f32,
    /// Zero.
    pub reserved_a: u32,
    /// Zero.
    pub reserved_b: u32,
}

/// Stretches that go round, 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MotionSchedule {
    /// The first of its stretches, which starts at 0.
    pub first: u32,
    /// At least one, by their start.
    pub count: u32,
    /// Seconds until it begins anew.
    pub loop_s: f32,
    /// Zero.
    pub reserved: u32,
}

/// Which schedule an instance goes by, 8 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MotionRecord {
    /// Index of the schedule; [`crowd_pack::NONE`]: it plays what its record says.
    pub schedule: u32,
    /// Seconds by which it is ahead.
    pub ahead_s: f32,
}

/// How poses are numbered in keys, a uniform of 16 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct PoseCounts {
    /// Bits of a key that say the pose; those above say the bucket.
    pub pose_bits: u32,
    /// All of these bits: a pose that nobody shares.
    pub own_pose: u32,
    /// Buckets; also the bucket of instances in none.
    pub bucket_count: u32,
    /// Those of meshes, which come first.
    pub mesh_count: u32,
}
