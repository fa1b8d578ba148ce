//! The pack's manifest: names, source skeleton and curves, options, measured errors. Bincode with a byte limit.

use crate::AnimationLayout;
use serde::{Deserialize, Serialize};

/// What is not for the GPU.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Manifest {
    /// Program and version that wrote the pack.
    pub generator: String,
    /// How the animation section stores matrices.
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
    /// Frames a second asked for.
    pub fps: f32,
    /// Seams and classes at full detail.
    pub seams: ManifestSeams,
    /// Accumulated error of each level of the order, coarsest first.
    pub levels: Vec<ManifestLevel>,
    /// Measured levels, coarsest first.
    pub measured: Vec<ManifestMeasured>,
    /// How measuring was done: points a side and frame.
    pub samples_per_frame: u32,
    /// How measuring was done: frames.
    pub measured_frames: u32,
    /// What kept the coarsest level from going further.
    pub blocked: ManifestBlocked,
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
    /// Triangles of the source that had two corners at one place.
    pub degenerate_triangle_count: u32,
    /// Edges with more than two triangles.
    pub non_manifold_edge_count: u32,
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

/// A measured level.
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
}

/// Positions that could not move any more at the coarsest level, by what held them.
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
}
