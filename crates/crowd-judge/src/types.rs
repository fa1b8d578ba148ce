//! What goes in and what comes out.

use crowd_raster::{Material, Texture};

/// Rows of an affine matrix: `out[r] = m[r][0]*x + m[r][1]*y + m[r][2]*z + m[r][3]`.
pub type Mat3x4 = [[f32; 4]; 3];

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why nothing was judged.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Error {
    /// The caller is wrong.
    #[error("{what}: found {found}, allowed {allowed}")]
    Parameter {
        /// Which value.
        what: &'static str,
        /// Found.
        found: String,
        /// Allowed.
        allowed: String,
    },
}

/// A skinned, textured mesh. Per-vertex arrays have one entry per vertex.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SkinnedMesh {
    /// Bind-space positions, metres, finite.
    pub positions: Vec<[f32; 3]>,
    /// Bind-space normals.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates, v down.
    pub uvs: Vec<[f32; 2]>,
    /// Linear RGBA8, multiplied into the material.
    pub colors: Vec<[u8; 4]>,
    /// Joint indices.
    pub joints: Vec<[u16; 4]>,
    /// Weights, summing to 1.
    pub weights: Vec<[f32; 4]>,
    /// Vertex indices, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// Material of each triangle; one entry per triangle.
    pub triangle_materials: Vec<u16>,
}

/// What the triangles of the original and of its levels are painted with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Paint {
    /// Materials, as `triangle_materials` names them.
    pub materials: Vec<Material>,
    /// Textures, as the materials name them.
    pub textures: Vec<Texture>,
}

/// Poses to judge in.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct JudgedPoses {
    /// One premultiplied matrix a joint: the pose at rest.
    pub rest: Vec<Mat3x4>,
    /// Poses in motion, each with one matrix a joint; none for a character without clips.
    pub moving: Vec<Vec<Mat3x4>>,
}

/// A level to judge.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Level {
    /// The level; its materials are the original's.
    pub mesh: SkinnedMesh,
    /// Its own matrices, as many poses as the original has, where it has another skeleton; `None` for the original's.
    pub poses: Option<JudgedPoses>,
}

/// How much is measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JudgeOptions {
    /// Points on each side, fixed on the surface over all poses.
    pub points: u32,
    /// Whether pictures are drawn: 6 views of 5 poses, 256 x 256 pixels of 3 x 3 samples.
    pub pictures: bool,
}

impl JudgeOptions {
    /// 10,000 points a side and pictures.
    pub const FULL: Self = Self { points: 10_000, pictures: true };
    /// 2,000 points a side, no pictures: for tuning, distances within some 2 %.
    pub const QUICK: Self = Self { points: 2_000, pictures: false };
}

/// How far a level is from the original. Distances in percent of the diagonal of the original's box at rest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Verdict {
    /// Triangles of the level.
    pub triangles: u32,
    /// Root mean square distance over the moving poses, both ways; over the pose at rest where nothing moves.
    pub animated_rms: f64,
    /// Root mean square distance at rest, both ways.
    pub rest_rms: f64,
    /// Mean distance over the moving poses.
    pub mean: f64,
    /// 99 of 100 distances over the moving poses are not larger.
    pub p99: f64,
    /// Largest distance over the moving poses.
    pub max: f64,
    /// The moving pose that has it; `None` where nothing moves.
    pub max_pose: Option<u32>,
    /// Mean angle between normals, degrees.
    pub normal_deg: f64,
    /// Root mean square difference of the base colour over its channels, sRGB 0 to 1.
    pub color_rms: f64,
    /// How far the texture slid, in texels: 95 of 100 points at rest slid no further. `None` without textures.
    pub uv_p95_texels: Option<f64>,
    /// How far the texture slid, root mean square, texels.
    pub uv_rms_texels: Option<f64>,
    /// Root mean square difference of pictures over the union of both silhouettes, sRGB 0 to 1; `None` when not drawn.
    pub image_rmse: Option<f64>,
    /// What only one of the silhouettes covers, in percent of their union; `None` when not drawn.
    pub silhouette_xor: Option<f64>,
    /// What the level misses of the original's silhouette, in percent of that; `None` when not drawn.
    pub silhouette_missed: Option<f64>,
    /// The same as a mean over the joints that move what is seen: a shin that thins to a sheet counts, however small it is beside the body.
    /// Joints of less than half a percent of what is seen are left out. `None` when not drawn.
    pub limbs_missed: Option<f64>,
}
