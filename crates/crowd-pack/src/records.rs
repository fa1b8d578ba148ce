//! GPU-shaped records: `repr(C)`, little-endian, no padding, uploaded as they lie.
//!
//! The same structs stand in `shaders/shared/records.wgsl`; a test compares sizes and offsets.

use bytemuck::{Pod, Zeroable};

/// Newest version of the format, that of packs with finishes.
pub const FORMAT_VERSION: u32 = 5;
/// That of packs with impostors and without finishes: version 5 but for its last three sections.
pub const IMPOSTORS_VERSION: u32 = 4;
/// Oldest version that is read, and that of packs with neither: version 4 but for its last two sections. A reader refuses every other.
pub const PLAIN_VERSION: u32 = 3;
/// First eight bytes of a pack.
pub const MAGIC: [u8; 8] = *b"CROWDPK\0";
/// No image; no vertices of their own.
pub const NONE: u32 = u32::MAX;

/// One vertex, 48 bytes. Indices are local to the character.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct VertexRecord {
    /// Bind-space position, metres.
    pub position: [f32; 3],
    /// Octahedral normal, two signed normalised 16-bit numbers, x in the low half.
    pub normal_oct: u32,
    /// Texture coordinates, v down.
    pub uv: [f32; 2],
    /// Linear colour, RGBA8, red in the low byte.
    pub color: u32,
    /// Low 16 bits: material, local to the character. High 16 bits: vertex class (0 regular, 1 companion, 2 fixed).
    pub material_class: u32,
    /// Four 16-bit joint indices, local to the character; first in the low half of the first word.
    pub joints: [u32; 2],
    /// Four unsigned normalised 16-bit weights that sum to 65535; same order. Joints of weight 0 exist all the same.
    pub weights: [u32; 2],
}

/// Entry `k` of a character's LOD table: the level for a vertex count of at most `k`. One entry for each k in 0..=V.
///
/// `vertex_count <= max(k, min_vertex_count)`, so companions are never split by a prefix.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct LodRecord {
    /// Vertices of the level.
    pub vertex_count: u32,
    /// Triangles of the level.
    pub triangle_count: u32,
}

/// Where a character's levels with index tables lie, 16 bytes; one record a character.
///
/// From `level_offset`: the quantised levels, coarsest first, full detail last; then the discrete ones, finest first.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct LevelSetRecord {
    /// First record in the levels section.
    pub level_offset: u32,
    /// Levels in geometric steps of their triangles, at least one.
    pub quantized_count: u32,
    /// Levels that someone asked for by ratio or error.
    pub discrete_count: u32,
    /// First vertex of the character's refitted levels.
    pub refit_vertex_offset: u32,
}

/// A level with an index table in cache order, 24 bytes.
///
/// Its triangles are those that reforming gives, each starting at some corner, in an order that suits a vertex cache.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct LevelRecord {
    /// Indices are below this: a prefix of the character's vertices, or the count of the level's own.
    pub vertex_count: u32,
    /// Triangles; three indices each.
    pub triangle_count: u32,
    /// First index, in the section of that width.
    pub index_offset: u32,
    /// 2 (section `indices_16`, where `vertex_count` is at most [`INDEX_16_VERTICES`]) or 4 (`indices_32`).
    pub index_bytes: u32,
    /// First vertex in `refit_vertices`, or [`NONE`] where the indices go to the character's vertices.
    pub refit_vertex_offset: u32,
    /// No point of the level or of full detail is farther from the other than this in the frames baked, metres.
    pub bound_m: f32,
}

/// Vertices of a level that 16-bit indices can name: index 65,535 is kept free, it restarts primitives.
pub const INDEX_16_VERTICES: u32 = 65_535;

impl LevelRecord {
    /// Bytes of an index for a level of that many vertices.
    pub fn index_bytes_for(vertex_count: u32) -> u32 {
        if vertex_count <= INDEX_16_VERTICES { 2 } else { 4 }
    }

    /// True where the level has vertices of its own.
    pub fn is_refit(&self) -> bool {
        self.refit_vertex_offset != NONE
    }
}

/// Offsets, counts and bounds of a character, 112 bytes. Offsets are in elements of the pack's sections.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct CharacterRecord {
    /// First vertex (also first entry of the collapse map).
    pub vertex_offset: u32,
    /// Vertices at full detail.
    pub vertex_count: u32,
    /// First triangle.
    pub triangle_offset: u32,
    /// Triangles at full detail.
    pub triangle_count: u32,
    /// First entry of the LOD table; it has `vertex_count + 1` entries.
    pub lod_offset: u32,
    /// Vertices of the coarsest level.
    pub min_vertex_count: u32,
    /// Triangles of the coarsest level.
    pub min_triangle_count: u32,
    /// Matrices a frame.
    pub joint_count: u32,
    /// First clip.
    pub clip_offset: u32,
    /// Clips, at least one.
    pub clip_count: u32,
    /// First material.
    pub material_offset: u32,
    /// Materials, at least one.
    pub material_count: u32,
    /// Sphere over all clips: centre, metres, and radius.
    pub sphere: [f32; 4],
    /// Box over all clips, least corner, metres.
    pub box_min: [f32; 3],
    /// Height of the bind pose, metres.
    pub height_m: f32,
    /// Box over all clips, greatest corner, metres.
    pub box_max: [f32; 3],
    /// First texel of the character's inverse bind matrices (four rows a joint); used by the split layout only, else 0.
    pub inverse_bind_offset: u32,
    /// How its joints are stored, see [`crate::JointStorage::of_code`]; 0 in the split layout.
    pub joint_storage: u32,
    /// No vertex is farther than this, metres, from where the matrices that the clips were sampled to put it, in any frame or between.
    pub storage_error_m: f32,
    /// Zero.
    pub reserved: [u32; 2],
}

/// A clip of a character, 48 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct ClipRecord {
    /// First texel of the clip in the animation section. Frame `f` begins `f * frame_texels` later, see [`crate::JointStorage`].
    pub texel_offset: u32,
    /// Frames, at least one.
    pub frame_count: u32,
    /// Seconds; 0 for a single pose.
    pub duration_s: f32,
    /// How fast the clip walks over the ground, metres a second: the speed at which planted feet stay where they are.
    pub ground_speed_m_s: f32,
    /// Sphere over this clip: centre, metres, and radius.
    pub sphere: [f32; 4],
    /// The root's displacement over the clip, metres.
    pub root_displacement_m: [f32; 3],
    /// Largest joint distance between last and first pose, metres: above 1 % of the height the clip does not loop.
    pub loop_gap_m: f32,
}

/// A material, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, Default)]
pub struct MaterialRecord {
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Index into the image table, or [`NONE`].
    pub image: u32,
    /// Bits, see [`material_flags`].
    pub flags: u32,
    /// Pixels with less alpha are not drawn; 0 for opaque.
    pub alpha_cutoff: f32,
    /// Zero.
    pub reserved: u32,
}

/// Bits of [`MaterialRecord::flags`].
pub mod material_flags {
    /// Back faces are drawn.
    pub const DOUBLE_SIDED: u32 = 1;
    /// No lighting.
    pub const UNLIT: u32 = 2;
    /// One normal a triangle.
    pub const FLAT: u32 = 4;
    /// Wrapping along u: 0 repeat, 1 clamp, 2 mirror, shifted by this.
    pub const WRAP_U_SHIFT: u32 = 4;
    /// Wrapping along v, shifted by this.
    pub const WRAP_V_SHIFT: u32 = 6;
    /// Mask after shifting.
    pub const WRAP_MASK: u32 = 3;
    /// glTF's filters, shifted by this: bit 0 enlarged texels are squares (NEAREST); times 2 for those smaller than pixels: 0
    /// `LINEAR_MIPMAP_LINEAR`, 1 `NEAREST_MIPMAP_NEAREST`, 2 `LINEAR_MIPMAP_NEAREST`, 3 `NEAREST_MIPMAP_LINEAR`, 4 `NEAREST`, 5 `LINEAR`.
    pub const FILTER_SHIFT: u32 = 8;
    /// Mask after shifting.
    pub const FILTER_MASK: u32 = 15;
    /// The largest number of filters.
    pub const MOST_FILTERS: u32 = 11;

    /// Whether bits 4 to 11 of flags, shifted down, are wraps and filters that exist.
    pub const fn is_sampler(bits: u32) -> bool {
        bits & WRAP_MASK <= 2 && (bits >> 2) & WRAP_MASK <= 2 && (bits >> 4) <= MOST_FILTERS
    }
}

/// An encoded image inside the image bytes, 32 bytes.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct ImageRecord {
    /// First byte in the `image_bytes` section, a multiple of 64.
    pub byte_offset: u64,
    /// Bytes.
    pub byte_count: u64,
    /// Pixels.
    pub width: u32,
    /// Pixels.
    pub height: u32,
    /// 0 PNG, 1 JPEG, 2 WebP; kept as found in the source.
    pub encoding: u32,
    /// Zero.
    pub reserved: u32,
}

/// A character's impostors, 48 bytes: small pictures of it (tiles) from around, at some moments of its clips.
///
/// Tiles stand in rows of one elevation; `elevation_count` such rows are a pose, `pose_count` poses a clip. See `docs/FORMAT.md`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable, Default)]
pub struct ImpostorRecord {
    /// Texels that a tile is wide and high, a power of two.
    pub tile_px: u32,
    /// Directions around the character.
    pub azimuth_count: u32,
    /// Directions upwards, from the horizon on.
    pub elevation_count: u32,
    /// Moments of a clip, evenly spread.
    pub pose_count: u32,
    /// Clips that have pictures, the first ones of the character.
    pub clip_count: u32,
    /// Zero.
    pub reserved: u32,
    /// First byte of the colours in the `impostor_bytes` section, a multiple of 64; a PNG.
    pub color_byte_offset: u64,
    /// First byte of the normals there, a multiple of 64; a PNG of the same size.
    pub normal_byte_offset: u64,
    /// Bytes of the colours.
    pub color_byte_count: u32,
    /// Bytes of the normals.
    pub normal_byte_count: u32,
}

impl ImpostorRecord {
    /// Texels that the pictures are wide.
    pub fn width(&self) -> u64 {
        u64::from(self.tile_px) * u64::from(self.azimuth_count)
    }

    /// Texels that they are high.
    pub fn height(&self) -> u64 {
        let rows = u64::from(self.elevation_count).saturating_mul(self.poses());
        u64::from(self.tile_px).saturating_mul(rows)
    }

    /// Poses of all clips.
    pub fn poses(&self) -> u64 {
        u64::from(self.pose_count) * u64::from(self.clip_count)
    }
}

/// What the animation section stores of a joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AnimationLayout {
    /// `world * inverse_bind`, as each character's [`crate::JointStorage`] says (default; 16 to 48 bytes).
    #[default]
    Premultiplied3x4,
    /// Dong 2019 §5.1: four RGBA32F texels a joint with `world` alone; inverse bind matrices in their own section. What the papers store, to
    /// compare with.
    Split4x4,
}

/// Bytes of a joint and frame in the papers' layout, [`AnimationLayout::Split4x4`].
pub const SPLIT_JOINT_BYTES: u32 = 64;

impl AnimationLayout {
    /// Texels of a frame of that many joints in that storage.
    pub fn frame_texels(self, storage: crate::JointStorage, joint_count: u32) -> u32 {
        match self {
            Self::Premultiplied3x4 => storage.frame_texels(joint_count),
            Self::Split4x4 => joint_count * 4,
        }
    }
}

impl CharacterRecord {
    /// How its joints are stored; `None` for a number that stands for nothing, which no [`crate::Pack`] has.
    pub fn storage(&self) -> Option<crate::JointStorage> {
        crate::JointStorage::of_code(self.joint_storage)
    }
}
