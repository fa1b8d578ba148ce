//! A pack in memory: [`PackContents`] owned for writing, [`Pack`] checked for reading.

use crate::{
    CharacterRecord, ClipRecord, ImageRecord, LevelRecord, LevelSetRecord, LodRecord, Manifest, MaterialRecord,
    VertexRecord,
};

/// Everything that goes into a pack. All characters share one section per kind of data (Dong 2019 §5).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PackContents {
    /// Names, skeletons, curves, errors.
    pub manifest: Manifest,
    /// One per character.
    pub characters: Vec<CharacterRecord>,
    /// All characters' vertices, each character's in collapse order.
    pub vertices: Vec<VertexRecord>,
    /// All characters' triangles, indices local to the character.
    pub triangles: Vec<[u32; 3]>,
    /// Target of each vertex, local to the character; parallel to `vertices`.
    pub collapse_map: Vec<u32>,
    /// LOD tables, `vertex_count + 1` entries a character.
    pub lods: Vec<LodRecord>,
    /// All clips.
    pub clips: Vec<ClipRecord>,
    /// Animation texels (rows of matrices), see [`ClipRecord::texel_offset`].
    pub animation: Vec<[f32; 4]>,
    /// Inverse bind matrices, four rows a joint; empty unless the layout is split.
    pub inverse_binds: Vec<[f32; 4]>,
    /// All materials.
    pub materials: Vec<MaterialRecord>,
    /// All images; identical ones are stored once.
    pub images: Vec<ImageRecord>,
    /// Encoded images, each starting at a multiple of 64.
    pub image_bytes: Vec<u8>,
    /// Times and values of the source curves.
    pub track_values: Vec<f32>,
    /// Where each character's levels with index tables lie.
    pub level_sets: Vec<LevelSetRecord>,
    /// All levels with index tables.
    pub levels: Vec<LevelRecord>,
    /// Indices of levels of few vertices, local to the character or to the refitted level.
    pub indices_16: Vec<u16>,
    /// Indices of the others.
    pub indices_32: Vec<u32>,
    /// Vertices of refitted levels.
    pub refit_vertices: Vec<VertexRecord>,
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WriteReport {
    /// Bytes of the file.
    pub pack_bytes: u64,
    /// Name and bytes of each section.
    pub sections: Vec<(String, u64)>,
}

/// A pack that passed every check, so that its users need none.
///
/// - Characters cover `vertices`, `triangles`, `lods`, `clips` and `materials` exactly and in order, their clips
///   `animation`, and in the split layout their joints `inverse_binds`.
/// - Triangle corners are below `vertex_count`; materials, joints and classes of vertices exist; weights sum to 65535.
/// - `collapse_map[v] < v`, or `v` itself below `min_vertex_count`: looking an index up ends.
/// - LOD tables are monotone, from the coarsest level to full detail, with at most `max(k, min_vertex_count)` vertices.
/// - Levels with index tables cover `levels`, `indices_16`, `indices_32` and `refit_vertices` exactly and in order; their
///   indices are below their vertex counts, and those without vertices of their own are levels of the LOD table.
/// - Images lie within `image_bytes` at multiples of 64; materials name existing images. Images are not decoded.
/// - The manifest has as many joints, clips and materials as the records; parents come before children; tracks lie within
///   `track_values` and have rising times; character names are unique, clip names within their character.
/// - Every number is finite and every count within [`crate::limits`].
///
/// Not checked: that no level has degenerate triangles, that index tables hold the reformed triangles, and that the errors are what they say (`crowdbake verify` does).
#[derive(Debug)]
pub struct Pack {
    pub(crate) contents: PackContents,
}

impl Pack {
    /// The checked contents.
    pub fn contents(&self) -> &PackContents {
        &self.contents
    }

    /// Index of the character of that name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.contents.manifest.characters.iter().position(|c| c.name == name)
    }
}
