//! The pack's manifest: names, source skeleton and curves, options, measured errors. Bincode with a byte limit.

use crate::AnimationLayout;
use serde::{Deserialize, Serialize};

/// What is not for the GPU.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Manifest {
    /// Program and version that wrote the pack.
    pub generator: String,
    /// What the animation section stores of a joint.
    pub animation_layout: AnimationLayout,
    /// One entry per character record.
    pub characters: Vec<ManifestCharacter>,
}

/// Names and provenance of a character.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestCharacter {
    /// Unique within the pack.
    pub name: String,
    /// File name (without folder) it was baked from.
    pub source: String,
    /// Node tree, parents first.
    pub nodes: Vec<ManifestNode>,
    /// Joints: one per matrix of a frame.
    pub joints: Vec<ManifestJoint>,
    /// Clips: one per clip record.
    pub clips: Vec<ManifestClip>,
    /// Names of the materials: one per material record.
    pub materials: Vec<String>,
    /// Parts of the source.
    pub parts: Vec<ManifestPart>,
    /// Criteria the order was made with: `wedge` or `peng2011`.
    pub criteria: String,
    /// Frames a second asked for; 0 for each clip at the rate of its keys.
    pub fps: f32,
    /// Seams and classes at full detail.
    pub seams: ManifestSeams,
    /// Accumulated error of each level of the order, coarsest first.
    pub levels: Vec<ManifestLevel>,
    /// The quantised levels as measured, coarsest first: one per record.
    pub measured: Vec<ManifestMeasured>,
    /// The discrete levels, finest first: one per record.
    pub discrete: Vec<ManifestDiscrete>,
    /// How measuring was done.
    pub measuring: ManifestMeasuring,
    /// What kept the coarsest level from going further.
    pub blocked: ManifestBlocked,
    /// For each vertex of the coarsest level, what keeps its position there, one of [`obstacle`]; empty where nobody knows.
    pub obstacles: Vec<u8>,
    /// Warnings of the import and the bake, as sentences.
    pub warnings: Vec<String>,
}

/// A node at rest.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestNode {
    /// Name.
    pub name: String,
    /// Parent, smaller than the node's own index.
    pub parent: Option<u32>,
    /// Metres.
    pub translation: [f32; 3],
    /// Unit quaternion x y z w.
    pub rotation: [f32; 4],
    /// Factors.
    pub scale: [f32; 3],
}

/// A joint.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestJoint {
    /// Node.
    pub node: u32,
    /// Column-major 4x4.
    pub inverse_bind: [f32; 16],
}

/// A clip with its source curves.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestClip {
    /// Name, unique within the character.
    pub name: String,
    /// Source curves, kept for export.
    pub tracks: Vec<ManifestTrack>,
    /// When feet stand on the ground, by joint, then by time.
    pub contacts: Vec<ManifestContact>,
    /// Mean speed over the ground of feet that stand, at the clip's ground speed, metres a second.
    pub slide_m_s: f32,
    /// Where the character has to be, x and z in metres beside its even way, for standing feet to stay: evenly spread over the clip, the last
    /// as the first. Empty where the clip does not walk.
    pub root_path_m: Vec<[f32; 2]>,
    /// The slide that is left along that path, metres a second.
    pub rooted_slide_m_s: f32,
}

/// A joint whose sole stands on the ground for a while.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestContact {
    /// The joint.
    pub joint: u32,
    /// Seconds into the clip.
    pub start_s: f32,
    /// Seconds into the clip, after `start_s` and within the duration.
    pub end_s: f32,
}

/// A curve; times and values lie in the `track_values` section.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestTrack {
    /// Node.
    pub node: u32,
    /// 0 translation, 1 rotation, 2 scale.
    pub property: u8,
    /// 0 step, 1 linear, 2 cubic spline.
    pub interpolation: u8,
    /// First float of the times.
    pub time_offset: u32,
    /// Keys.
    pub key_count: u32,
    /// First float of the values.
    pub value_offset: u32,
    /// Floats of the values.
    pub value_count: u32,
}

impl ManifestTrack {
    /// Floats of one key: 3 (translation, scale) or 4 (rotation), three times that for cubic splines.
    pub fn floats_per_key(&self) -> u64 {
        let floats = if self.property == 1 { 4 } else { 3 };
        if self.interpolation == 2 { floats * 3 } else { floats }
    }
}

/// A part of the source: triangles with one material.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestPart {
    /// Name.
    pub name: String,
    /// Material, local to the character.
    pub material: u32,
    /// Triangles in the source.
    pub triangle_count: u32,
    /// Follows one joint.
    pub rigid: bool,
}

/// Seams and classes (Peng 2011 §4).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestSeams {
    /// Distinct positions.
    pub position_count: u32,
    /// Vertices by UV and material: the paper's universal index.
    pub wedge_count: u32,
    /// Positions with two or more wedges.
    pub seam_position_count: u32,
    /// Wedges of class fixed.
    pub fixed_count: u32,
    /// Of these, on an open border.
    pub border_count: u32,
    /// Wedges of class companioned.
    pub companion_count: u32,
    /// Wedges of class regular.
    pub regular_count: u32,
    /// Triangles of the source left out: two corners at one place.
    pub degenerate_triangle_count: u32,
    /// Triangles of the source left out: they repeat another one.
    pub duplicate_triangle_count: u32,
    /// Triangles kept that lie on another one, turned round or with other attributes.
    pub coincident_triangle_count: u32,
    /// Edges with more than two triangles.
    pub non_manifold_edge_count: u32,
    /// Positions on such an edge, or where surfaces meet in a point.
    pub non_manifold_position_count: u32,
}

/// A level of the order.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestLevel {
    /// Vertices.
    pub vertex_count: u32,
    /// Triangles.
    pub triangle_count: u32,
    /// Accumulated quadric error, metres.
    pub error_m: f32,
}

/// How the levels were measured: enough to measure them again.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestMeasuring {
    /// Points a side and frame that the mean is taken over.
    pub samples_per_frame: u32,
    /// Frames, counted over all clips, that the mean is taken over; rising.
    pub mean_frames: Vec<u32>,
    /// Further frames that the maximum looks at, those where the levels are worst; rising.
    pub worst_frames: Vec<u32>,
}

/// A level that someone asked for.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestDiscrete {
    /// Unique within the character: `lod1` the finest.
    pub name: String,
    /// What was asked for.
    pub target: ManifestTarget,
    /// False where even the coarsest level has more triangles than asked for.
    pub reached: bool,
    /// What it is.
    pub measured: ManifestMeasured,
}

/// What a discrete level was asked to be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ManifestTarget {
    /// At most this share of the triangles.
    Ratio(f32),
    /// A bound of at most so many metres.
    ErrorM(f32),
    /// A bound of at most this share of the character's height.
    ErrorHeight(f32),
    /// A bound of at most so many pixels, where the character is so many pixels high.
    Pixels(f32, f32),
    /// A root mean square distance of at most so many metres.
    RmsM(f32),
    /// A root mean square distance of at most this share of the character's height.
    RmsHeight(f32),
    /// A root mean square distance of at most so many pixels, where the character is so many pixels high.
    RmsPixels(f32, f32),
}

impl Default for ManifestTarget {
    fn default() -> Self {
        Self::Ratio(1.0)
    }
}

/// A measured level. Distances are those of closest points, both ways, over the frames of [`ManifestMeasuring`]; the largest of a
/// refitted level over its own `max_frame` as well.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ManifestMeasured {
    /// Vertices.
    pub vertex_count: u32,
    /// Triangles.
    pub triangle_count: u32,
    /// Root mean square distance, metres.
    pub rms_m: f32,
    /// Largest distance, metres.
    pub max_m: f32,
    /// Clip of the largest.
    pub max_clip: u32,
    /// Frame of the largest within its clip.
    pub max_frame: u32,
    /// A distance that no point exceeds in any frame, metres; as in the level's record. Never smaller than that of a finer level.
    pub bound_m: f32,
    /// Texture drift between closest points that 95 % of the surface stays below, texels; 0 without textures.
    pub uv_drift_p95_texels: f32,
    /// Mean angle between the normals of closest points, degrees.
    pub normal_mean_deg: f32,
    /// `bound_m` where the character is [`REFERENCE_HEIGHT_PX`] high on the screen, pixels.
    pub bound_px: f32,
    /// Share of the surface that has come out through a layer which covers it at full detail, mean over frames, 0..=1.
    pub poked_share: f32,
}

/// Height on the screen that pixel errors of levels refer to.
pub const REFERENCE_HEIGHT_PX: f32 = 720.0;

/// Positions of the coarsest level, by what keeps them there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ManifestBlocked {
    /// Open border or class fixed.
    pub fixed: u32,
    /// Seam without a partner.
    pub seam: u32,
    /// Link condition.
    pub topology: u32,
    /// Flipped triangle.
    pub flip: u32,
    /// Nothing: these could still move, the order was ended.
    pub ended: u32,
}

/// Entries of [`ManifestCharacter::obstacles`], as [`ManifestBlocked`] counts them.
pub mod obstacle {
    /// Open border or class fixed.
    pub const FIXED: u8 = 1;
    /// Seam without a partner.
    pub const SEAM: u8 = 2;
    /// Link condition.
    pub const TOPOLOGY: u8 = 3;
    /// Flipped triangle.
    pub const FLIP: u8 = 4;
    /// Nothing: the order was ended.
    pub const ENDED: u8 = 5;
}
