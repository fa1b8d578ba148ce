//! What the rasteriser draws and into what.

use glam::{Mat4, Vec3};

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a picture could not be made.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An image did not decode.
    #[error("image: {0}")]
    Image(String),
    /// The caller is wrong.
    #[error("{0}")]
    Parameter(String),
}

/// Colour and depth. Row 0 is the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// sRGB-encoded RGBA8, `width * height`.
    pub color: Vec<[u8; 4]>,
    /// Depth 0 (near) to 1 (far), `width * height`.
    pub depth: Vec<f32>,
}

impl Target {
    /// A target filled with opaque `color` (sRGB) and depth 1.
    pub fn new(width: u32, height: u32, color: [u8; 4]) -> Self {
        let n = width as usize * height as usize;
        Self { width, height, color: vec![color; n], depth: vec![1.0; n] }
    }
}

/// Camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// World to clip space, depth 0 to 1 (wgpu's convention, Y up).
    pub clip_from_world: Mat4,
    /// Camera position, world space, metres.
    pub eye: Vec3,
}

/// How to fill triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Fill {
    /// Material, texture and light.
    #[default]
    Shaded,
    /// `Batch::colors` alone, unlit (vertex classes, error heat maps).
    VertexColor,
    /// Shaded with the triangles' edges drawn over it.
    Wireframe,
    /// Material and texture without light.
    BaseColor,
    /// Normals towards the eye's side: a number from -1 to 1 is a byte from 1 to 255. Alpha is 0 where light changes nothing, else 255.
    Normal,
}

/// Triangles in world space with their attributes. Per-vertex slices have one entry per vertex.
#[derive(Debug, Clone, Copy)]
pub struct Batch<'a> {
    /// World positions, metres.
    pub positions: &'a [[f32; 3]],
    /// World normals, need not be unit length.
    pub normals: &'a [[f32; 3]],
    /// Texture coordinates, v down.
    pub uvs: &'a [[f32; 2]],
    /// Linear RGBA8, multiplied into the material.
    pub colors: &'a [[u8; 4]],
    /// Material of each vertex (that of a triangle is its first corner's).
    pub vertex_materials: &'a [u16],
    /// Counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// Materials.
    pub materials: &'a [Material],
    /// Textures the materials name.
    pub textures: &'a [Texture],
    /// How to fill.
    pub fill: Fill,
}

/// Surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Index into the batch's textures.
    pub texture: Option<u32>,
    /// Along u.
    pub wrap_u: Wrap,
    /// Along v.
    pub wrap_v: Wrap,
    /// Pixels with less alpha are dropped; 0 for opaque.
    pub alpha_cutoff: f32,
    /// Back faces are drawn, with the normal turned to the eye.
    pub double_sided: bool,
    /// No lighting.
    pub unlit: bool,
    /// One normal a triangle.
    pub flat: bool,
}

/// Texture wrapping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Wrap {
    /// Tile.
    #[default]
    Repeat,
    /// Hold the border.
    Clamp,
    /// Tile, every other one mirrored.
    Mirror,
}

/// A texture with its mip levels, linear RGB (decoded from sRGB) and alpha, as sRGB-encoded RGBA8 like the GPU stores it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Texture {
    /// Level 0 first; each level halves (rounding down, at least 1) the one before.
    pub mips: Vec<Mip>,
}

/// One mip level.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mip {
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// sRGB-encoded RGBA8.
    pub texels: Vec<[u8; 4]>,
}
