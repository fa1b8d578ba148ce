//! A pack made ready for the stages: records as they lie, textures decoded into layers of one size.

use crowd_pack::{CharacterRecord, ClipRecord, LodRecord, MaterialRecord, Pack, VertexRecord};

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a crowd could not be set up.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An image of the pack did not decode.
    #[error("image {index} of the pack: {problem}")]
    Image {
        /// Index in the image table.
        index: usize,
        /// The decoder's word.
        problem: String,
    },
    /// The adapter's limits do not allow it.
    #[error("{what}: needs {needed}, the adapter allows {allowed}; {remedy}")]
    Limit {
        /// Of what.
        what: &'static str,
        /// Needed.
        needed: u64,
        /// Allowed.
        allowed: u64,
        /// What the user can do.
        remedy: &'static str,
    },
    /// No adapter, no device.
    #[error("no usable GPU: {0}")]
    NoAdapter(String),
    /// An instance names a character or clip that is not there.
    #[error("instance {index}: {what} {found}, the pack has {allowed}")]
    Instance {
        /// Of the instance.
        index: usize,
        /// `character` or `clip`.
        what: &'static str,
        /// Found.
        found: u32,
        /// Count.
        allowed: u32,
    },
}

/// CPU-side copy of everything the stages read. All characters in one set of arrays (Dong 2019 §5).
#[derive(Debug, Clone, Default)]
pub struct CrowdData {
    /// Characters.
    pub characters: Vec<CharacterRecord>,
    /// Vertices in collapse order.
    pub vertices: Vec<VertexRecord>,
    /// Triangles, indices local to the character.
    pub triangles: Vec<[u32; 3]>,
    /// Collapse targets, local to the character.
    pub collapse_map: Vec<u32>,
    /// LOD tables.
    pub lods: Vec<LodRecord>,
    /// Clips.
    pub clips: Vec<ClipRecord>,
    /// Rows of premultiplied 3x4 palettes, three a joint and frame (a split pack is multiplied on loading, and the
    /// clips' texel offsets are rewritten).
    pub animation: Vec<[f32; 4]>,
    /// Materials; `image` is a layer index here, or `crowd_pack::NONE`.
    pub materials: Vec<MaterialRecord>,
    /// Texture layers, all `layer_side` x `layer_side`, sRGB-encoded RGBA8 with mip levels.
    pub layers: Vec<TextureLayer>,
    /// Side of a layer in pixels, a power of two.
    pub layer_side: u32,
}

/// One decoded texture, resampled to the common size, with all mip levels down to 1 x 1.
#[derive(Debug, Clone, Default)]
pub struct TextureLayer {
    /// Level 0 first, tightly packed RGBA8.
    pub mips: Vec<Vec<[u8; 4]>>,
}

impl CrowdData {
    /// Unpacks. `max_layer_side` bounds texture memory (1024 is sensible for a crowd).
    pub fn from_pack(pack: &Pack, max_layer_side: u32) -> Result<Self> {
        let _ = (pack, max_layer_side);
        unimplemented!("crowd-stages: being written")
    }
}
