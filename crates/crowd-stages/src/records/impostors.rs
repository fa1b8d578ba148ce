//! What the draw is told of impostors.

use bytemuck::{Pod, Zeroable};

/// How tiles lie in the textures, a uniform of 16 bytes. A layer has its poses below each other, a pose its elevations, a row its azimuths.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct ImpostorSheet {
    /// Texels that a tile is wide and high.
    pub tile_px: u32,
    /// Directions around.
    pub azimuth_count: u32,
    /// Directions upwards.
    pub elevation_count: u32,
    /// Poses of a layer.
    pub poses_a_layer: u32,
}

/// A corner of an impostor, 48 bytes, in the words of [`crowd_pack::VertexRecord`]; goes to the GPU as a vertex buffer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct ImpostorCorner {
    /// 0 to 3, from the lower left one on against the clock.
    pub corner: u32,
    /// Its character.
    pub character: u32,
    /// The character's first pose among all.
    pub first_pose: u32,
    /// Poses of a clip.
    pub pose_count: u32,
    /// Clips that have poses.
    pub clip_count: u32,
    /// Left, top, right and bottom of what is drawn of a tile, texels.
    pub bounds: [u8; 4],
    /// Zero.
    pub reserved_a: u32,
    /// [`crowd_pack::NONE`], which is no vertex's material and class.
    pub mark: u32,
    /// Zero.
    pub reserved_b: [u32; 4],
}
