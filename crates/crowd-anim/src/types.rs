//! What goes in and what comes out.

use glam::{Mat4, Quat, Vec3};

/// Rows of an affine matrix: `out[r] = m[r][0]*x + m[r][1]*y + m[r][2]*z + m[r][3]`.
pub type Mat3x4 = [[f32; 4]; 3];

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why nothing was sampled.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The caller is wrong.
    #[error("{what}: found {found}, allowed {allowed}")]
    Parameter {
        /// Which value.
        what: String,
        /// Found.
        found: String,
        /// Allowed.
        allowed: String,
    },
}

/// Translation, rotation, scale: a node's local transform, `T * R * S`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trs {
    /// Metres.
    pub translation: Vec3,
    /// Unit quaternion.
    pub rotation: Quat,
    /// Factors.
    pub scale: Vec3,
}

/// The node tree at rest. Both arrays have one entry per node; parents come before children.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Skeleton {
    /// Parent of each node, smaller than the node's own index.
    pub parents: Vec<Option<u32>>,
    /// Local transform of each node at rest.
    pub rest: Vec<Trs>,
}

/// A matrix that vertices follow: `world(node) * inverse_bind`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Joint {
    /// Index into [`Skeleton::parents`].
    pub node: u32,
    /// Bind space to joint space.
    pub inverse_bind: Mat4,
}

/// What a track moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Property {
    /// Metres, 3 floats a key.
    Translation,
    /// Unit quaternion, 4 floats a key.
    Rotation,
    /// Factors, 3 floats a key.
    Scale,
}

/// How a track goes from key to key (glTF 2.0, appendix C).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interpolation {
    /// Holds the key's value.
    Step,
    /// Linear, spherical for rotations.
    Linear,
    /// Hermite spline; values hold in-tangent, value, out-tangent a key.
    CubicSpline,
}

/// One curve, borrowed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackView<'a> {
    /// Index into the skeleton's nodes.
    pub node: u32,
    /// What it moves.
    pub property: Property,
    /// How it goes from key to key.
    pub interpolation: Interpolation,
    /// Key times, seconds, strictly increasing.
    pub times: &'a [f32],
    /// Values, see [`Property`] and [`Interpolation`].
    pub values: &'a [f32],
}

/// One clip, borrowed.
#[derive(Debug, Clone, PartialEq)]
pub struct ClipView<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its curves.
    pub tracks: Vec<TrackView<'a>>,
}

/// A clip as poses at even times.
#[derive(Debug, Clone, PartialEq)]
pub struct SampledClip {
    /// Its name.
    pub name: String,
    /// Seconds; 0 for a single pose.
    pub duration_s: f32,
    /// Frames, at least 1. Frame `i` shows time `duration_s * i / (frame_count - 1)`.
    pub frame_count: u32,
    /// Premultiplied palettes `world(node) * inverse_bind`, `frame_count * joint_count`, frame by frame.
    pub palettes: Vec<Mat3x4>,
    /// `world(node)` alone in the papers' layout, rows of 4x4 matrices, `frame_count * joint_count`, frame by frame.
    pub worlds: Vec<[[f32; 4]; 4]>,
    /// Where the character goes during the clip.
    pub root_motion: RootMotion,
    /// Largest distance, in metres, between a joint's origin in the first and in the last frame, root motion removed.
    pub loop_gap_m: f32,
}

/// Travel of the root over one clip. Kept in the poses, reported here.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RootMotion {
    /// The moving node: the first, from the root down, that has a translation track; `None` when there is none.
    pub node: Option<u32>,
    /// Its displacement from the first to the last frame, metres, in character space.
    pub displacement_m: [f32; 3],
}

/// Sphere and axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bounds {
    /// Box, least corner, metres.
    pub min: [f32; 3],
    /// Box, greatest corner, metres.
    pub max: [f32; 3],
    /// Sphere's centre, metres.
    pub center: [f32; 3],
    /// Sphere's radius, metres.
    pub radius: f32,
}
