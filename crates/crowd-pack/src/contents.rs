//! A pack in memory: [`PackContents`] owned for writing, [`Pack`] checked for reading.

use crate::{
    CharacterRecord, ClipRecord, Finishes, ImageRecord, ImpostorRecord, LevelRecord, LevelSetRecord, LodRecord,
    Manifest, ManifestMeasured, MaterialRecord, NONE, Texel, VertexRecord,
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
    /// Animation texels, see [`ClipRecord::texel_offset`] and [`crate::JointStorage`].
    pub animation: Vec<Texel>,
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
    /// Impostors, one a character or none at all.
    pub impostors: Vec<ImpostorRecord>,
    /// Their encoded pictures, each starting at a multiple of 64.
    pub impostor_bytes: Vec<u8>,
    /// What materials have beside their base colour, and names; for exports.
    pub finishes: Finishes,
    /// Images of the finishes; identical ones are stored once. Not for drawing.
    pub finish_images: Vec<ImageRecord>,
    /// They, encoded, each starting at a multiple of 64.
    pub finish_bytes: Vec<u8>,
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct WriteReport {
    /// Bytes of the file.
    pub pack_bytes: u64,
    /// Name and bytes of each section.
    pub sections: Vec<(String, u64)>,
}

impl PackContents {
    /// Gives every character that has no levels with index tables yet its coarsest level and full detail: the least that a pack needs, for
    /// packs that are put together by hand.
    ///
    /// Indices are those of the reformed triangles as they stand; distances are 0. Characters must cover `vertices`, `triangles` and
    /// `collapse_map` as they should; what they leave out stays out, and the checks of writing name it.
    pub fn store_end_levels(&mut self) {
        for index in self.level_sets.len()..self.characters.len() {
            let character = self.characters[index];
            let mut ends = vec![
                (character.min_vertex_count, character.min_triangle_count),
                (character.vertex_count, character.triangle_count),
            ];
            ends.dedup();
            self.level_sets.push(LevelSetRecord {
                level_offset: self.levels.len() as u32,
                quantized_count: ends.len() as u32,
                discrete_count: 0,
                refit_vertex_offset: self.refit_vertices.len() as u32,
            });
            for &(vertex_count, triangle_count) in &ends {
                self.push_level(&character, vertex_count, triangle_count);
            }
            if let Some(manifest) = self.manifest.characters.get_mut(index) {
                let measured = |(vertex_count, triangle_count)| ManifestMeasured {
                    vertex_count,
                    triangle_count,
                    ..Default::default()
                };
                manifest.measured = ends.into_iter().map(measured).collect();
            }
        }
    }

    fn push_level(&mut self, character: &CharacterRecord, vertex_count: u32, triangle_count: u32) {
        let map = self.collapse_map.get(character.vertex_offset as usize..).unwrap_or_default();
        let settle = |mut corner: u32| {
            while corner >= vertex_count {
                match map.get(corner as usize) {
                    Some(&target) if target < corner => corner = target,
                    _ => break,
                }
            }
            corner
        };
        let triangles = self.triangles.iter().skip(character.triangle_offset as usize).take(triangle_count as usize);
        let corners: Vec<u32> = triangles.flatten().map(|&corner| settle(corner)).collect();
        let index_bytes = LevelRecord::index_bytes_for(vertex_count);
        let index_offset = if index_bytes == 2 { self.indices_16.len() } else { self.indices_32.len() } as u32;
        if index_bytes == 2 {
            self.indices_16.extend(corners.into_iter().map(|corner| corner as u16));
        } else {
            self.indices_32.extend(corners);
        }
        let refit_vertex_offset = NONE;
        let level =
            LevelRecord { vertex_count, triangle_count, index_offset, index_bytes, refit_vertex_offset, bound_m: 0.0 };
        self.levels.push(level);
    }
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
/// - Impostors are there for every character or for none, all of one shape; their pictures cover `impostor_bytes` at multiples of 64. They
///   are not decoded.
/// - Finishes are there for every material or for none; their textures name existing images, which lie as the others do.
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
