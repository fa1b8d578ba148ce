//! What is in a pack or in an asset, as documents that print as tables or as JSON.

mod asset;
mod text;

pub use asset::inspect_asset;
pub(crate) use text::grouped;
pub use text::to_text;

use crate::bake::BakedCharacter;
use crate::lod_target::LodTarget;
use crate::report::SCHEMA_VERSION;
use crate::store_animation::storage_name;
use crate::unpack::Unpacked;
use crowd_lod::SeamReport;
use crowd_pack::{
    AnimationLayout, LevelRecord, ManifestCharacter, ManifestDiscrete, ManifestMeasured, ManifestSeams, PackContents,
    VertexRecord,
};
use serde::Serialize;
use std::path::Path;

/// A pack or an asset.
#[derive(Debug, Serialize)]
pub struct Inspection {
    /// Version of this document.
    pub schema_version: u32,
    /// `pack` or `asset`.
    pub kind: &'static str,
    /// The file.
    pub file: String,
    /// Its bytes; of an asset without external files.
    pub bytes: u64,
    /// Program and version that wrote the pack.
    pub generator: Option<String>,
    /// How matrices are stored in the pack: `3x4` or `4x4`.
    pub animation_layout: Option<&'static str>,
    /// Images stored.
    pub images: usize,
    /// Bytes of the images.
    pub image_bytes: u64,
    /// The characters.
    pub characters: Vec<CharacterInspection>,
}

/// A character.
#[derive(Debug, Serialize)]
pub struct CharacterInspection {
    /// Name.
    pub name: String,
    /// File it was baked from.
    pub source: String,
    /// What that file says of its makers, if anything.
    pub copyright: Option<String>,
    /// Full detail: vertices, seams split.
    pub vertices: u32,
    /// Full detail: triangles.
    pub triangles: u32,
    /// Coarsest level: vertices; of packs only.
    pub coarsest_vertices: Option<u32>,
    /// Coarsest level: triangles; of packs only.
    pub coarsest_triangles: Option<u32>,
    /// Levels of the continuous detail; of packs only.
    pub levels: Option<usize>,
    /// Criteria of the order; of packs only.
    pub criteria: Option<String>,
    /// Height at rest, metres; of packs only.
    pub height_m: Option<f32>,
    /// Radius of the sphere over all clips, metres; of packs only.
    pub radius_m: Option<f32>,
    /// Matrices a frame.
    pub joints: usize,
    /// Seams and classes.
    pub seams: Seams,
    /// Clips.
    pub clips: Vec<ClipInspection>,
    /// Materials.
    pub materials: Vec<MaterialInspection>,
    /// Parts of the source.
    pub parts: Vec<PartInspection>,
    /// Quantised levels, measured against full detail, coarsest first; of packs only.
    pub measured: Vec<MeasuredInspection>,
    /// How its animation is stored; of packs only.
    pub animation: Option<AnimationInspection>,
    /// Its impostors; of packs that have them.
    pub impostors: Option<ImpostorInspection>,
    /// Discrete levels, finest first; of packs only.
    pub discrete: Vec<DiscreteInspection>,
    /// Bytes of the index tables and refitted vertices; of packs only.
    pub table_bytes: Option<u64>,
    /// What keeps the coarsest level from going further; of packs only.
    pub blocked: Option<Blocked>,
    /// Warnings.
    pub warnings: Vec<String>,
}

/// How animation is stored.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct AnimationInspection {
    /// `f32`, `f16` or `quantized`; `4x4` in the papers' layout.
    pub storage: &'static str,
    /// The largest distance of a vertex from where the sampled clips put it, metres.
    pub error_m: f32,
    /// Frames over all clips.
    pub frames: u32,
    /// Frames over all clips at the rate they were sampled with.
    pub sampled_frames: u64,
    /// Of a bake alone: how far, metres, a vertex gets between two sampled frames from where the clips' curves put it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between_frames_m: Option<f32>,
    /// In which clip that is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub between_frames_clip: Option<String>,
    /// Bytes of all clips.
    pub bytes: u64,
    /// Bytes of the sampled frames in the papers' layout, 64 a joint.
    pub papers_bytes: u64,
    /// Bytes of the sampled frames in a texture of posed vertices, 8 a vertex (position and normal at 16 bits, as the smallest such textures have).
    pub vertex_texture_bytes: u64,
}

/// Impostors of a character.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct ImpostorInspection {
    /// Texels that a tile is wide and high.
    pub tile_px: u32,
    /// Directions: around and upwards.
    pub directions: [u32; 2],
    /// Clips that have pictures.
    pub clips: u32,
    /// Moments of a clip.
    pub poses_a_clip: u32,
    /// Bytes of the pictures.
    pub bytes: u64,
}

/// Seams and classes at full detail (Peng 2011, section 4.2).
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Seams {
    /// Distinct positions.
    pub positions: u32,
    /// Vertices by texture coordinate and material.
    pub wedges: u32,
    /// Positions with two or more wedges.
    pub seam_positions: u32,
    /// Wedges of class fixed.
    pub fixed: u32,
    /// Of these, on an open border.
    pub on_border: u32,
    /// Wedges of class companioned.
    pub companion: u32,
    /// Wedges of class regular.
    pub regular: u32,
    /// What is odd about the surface.
    #[serde(flatten)]
    pub odd: OddCounts,
}

/// What is odd about a surface at full detail.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct OddCounts {
    /// Triangles dropped: two corners at one place.
    pub degenerate_triangles: u32,
    /// Triangles dropped: they repeat another one.
    pub duplicate_triangles: u32,
    /// Triangles kept that lie on another one, turned round or with other attributes.
    pub coincident_triangles: u32,
    /// Edges with more than two triangles.
    pub non_manifold_edges: u32,
    /// Positions on such an edge, or where surfaces meet in a point.
    pub non_manifold_positions: u32,
}

impl OddCounts {
    /// As a pack says it.
    pub(crate) fn of_pack(seams: &ManifestSeams) -> Self {
        Self {
            degenerate_triangles: seams.degenerate_triangle_count,
            duplicate_triangles: seams.duplicate_triangle_count,
            coincident_triangles: seams.coincident_triangle_count,
            non_manifold_edges: seams.non_manifold_edge_count,
            non_manifold_positions: seams.non_manifold_position_count,
        }
    }

    /// What there is, in words; `None` where nothing is odd.
    pub fn words(&self) -> Option<String> {
        let kinds = [
            (self.degenerate_triangles, "degenerate triangles dropped"),
            (self.duplicate_triangles, "repeated triangles dropped"),
            (self.coincident_triangles, "triangles on top of another one"),
            (self.non_manifold_edges, "edges with more than two triangles"),
            (self.non_manifold_positions, "places where surfaces meet in a point or on such an edge"),
        ];
        let found: Vec<String> = kinds
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|&(count, what)| format!("{} {what}", grouped(count)))
            .collect();
        (!found.is_empty()).then(|| found.join(", "))
    }
}

/// A clip.
#[derive(Debug, Serialize)]
pub struct ClipInspection {
    /// Name.
    pub name: String,
    /// Seconds.
    pub duration_s: f32,
    /// Frames; of packs only.
    pub frames: Option<u32>,
    /// Curves.
    pub tracks: usize,
    /// How fast it walks over the ground, metres a second; of packs only.
    pub ground_speed_m_s: Option<f32>,
    /// Distance between first and last pose, metres; of packs only.
    pub loop_gap_m: Option<f32>,
    /// Times that a joint's sole stands; of packs only.
    pub contacts: Option<usize>,
    /// Mean speed over the ground of soles that stand, metres a second; of packs only.
    pub slide_m_s: Option<f32>,
    /// The same when the character keeps to the clip's path; of packs only.
    pub rooted_slide_m_s: Option<f32>,
}

/// A material.
#[derive(Debug, Serialize)]
pub struct MaterialInspection {
    /// Name.
    pub name: String,
    /// Linear RGBA.
    pub base_color: [f32; 4],
    /// Pixels of the texture.
    pub texture: Option<[u32; 2]>,
    /// Alpha below which nothing is drawn; 0 for opaque.
    pub alpha_cutoff: f32,
}

/// A part.
#[derive(Debug, Serialize)]
pub struct PartInspection {
    /// Name.
    pub name: String,
    /// Triangles in the source.
    pub triangles: u32,
    /// Follows one joint.
    pub rigid: bool,
}

/// A measured level: the one record of it in every document.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeasuredInspection {
    /// Vertices.
    pub vertices: u32,
    /// Triangles.
    pub triangles: u32,
    /// Root mean square distance, metres.
    pub rms_m: f32,
    /// Largest distance, metres.
    pub max_m: f32,
    /// Clip of the largest.
    pub max_clip: String,
    /// Frame of the largest within its clip.
    pub max_frame: u32,
    /// What no distance exceeds in any frame, metres.
    pub bound_m: f32,
    /// The same in pixels where the character is 720 pixels high on the screen.
    pub bound_px: f32,
    /// Texture drift that 95 % of the surface stays below, texels.
    pub uv_drift_p95_texels: f32,
    /// Mean angle between normals, degrees.
    pub normal_mean_deg: f32,
    /// Share of the surface that has come out through a layer which covers it at full detail.
    pub poked_share: f32,
}

/// A discrete level.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DiscreteInspection {
    /// Its name, as `export --lod` takes it.
    pub name: String,
    /// What was asked for, in words.
    pub target: String,
    /// False where even the coarsest level has more triangles.
    pub reached: bool,
    /// Has vertices of its own.
    pub refitted: bool,
    /// What it is.
    #[serde(flatten)]
    pub measured: MeasuredInspection,
}

/// Positions that cannot move at the coarsest level.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Blocked {
    /// On an open border or of class fixed.
    pub fixed: u32,
    /// On a seam without a partner.
    pub seam: u32,
    /// Link condition.
    pub topology: u32,
    /// Flipped triangle.
    pub flip: u32,
    /// Could still move: the detail was ended before.
    pub ended: u32,
}

/// Looks into a pack.
pub fn inspect_pack(path: &Path, bytes: u64, contents: &PackContents) -> Inspection {
    let characters = (0..contents.characters.len()).map(|index| inspect_packed(&Unpacked::new(contents, index)));
    Inspection {
        schema_version: SCHEMA_VERSION,
        kind: "pack",
        file: path.to_string_lossy().into_owned(),
        bytes,
        generator: Some(contents.manifest.generator.clone()),
        animation_layout: Some(match contents.manifest.animation_layout {
            AnimationLayout::Premultiplied3x4 => "3x4",
            AnimationLayout::Split4x4 => "4x4",
        }),
        images: contents.images.len(),
        image_bytes: contents.images.iter().map(|image| image.byte_count).sum(),
        characters: characters.collect(),
    }
}

fn inspect_packed(character: &Unpacked<'_>) -> CharacterInspection {
    let (record, manifest) = (character.record, character.manifest);
    let mut levels = character.lods.to_vec();
    levels.dedup();
    let clips = manifest.clips.iter().zip(character.clips).map(|(named, clip)| ClipInspection {
        name: named.name.clone(),
        duration_s: clip.duration_s,
        frames: Some(clip.frame_count),
        tracks: named.tracks.len(),
        ground_speed_m_s: Some(clip.ground_speed_m_s),
        loop_gap_m: Some(clip.loop_gap_m),
        contacts: Some(named.contacts.len()),
        slide_m_s: Some(named.slide_m_s),
        rooted_slide_m_s: Some(named.rooted_slide_m_s),
    });
    let materials = manifest.materials.iter().zip(character.materials).map(|(name, material)| MaterialInspection {
        name: name.clone(),
        base_color: material.base_color,
        texture: character.contents.images.get(material.image as usize).map(|image| [image.width, image.height]),
        alpha_cutoff: material.alpha_cutoff,
    });
    let parts = manifest.parts.iter().map(|part| PartInspection {
        name: part.name.clone(),
        triangles: part.triangle_count,
        rigid: part.rigid,
    });
    let measured = manifest.measured.iter().map(|level| inspect_measured(level, clip_name(manifest, level)));
    let b = manifest.blocked;
    CharacterInspection {
        name: manifest.name.clone(),
        source: manifest.source.clone(),
        copyright: character.credits().map(|credits| credits.copyright.clone()).filter(|line| !line.is_empty()),
        vertices: record.vertex_count,
        triangles: record.triangle_count,
        coarsest_vertices: Some(record.min_vertex_count),
        coarsest_triangles: Some(record.min_triangle_count),
        levels: Some(levels.len()),
        criteria: Some(manifest.criteria.clone()),
        height_m: Some(record.height_m),
        radius_m: Some(record.sphere[3]),
        joints: manifest.joints.len(),
        seams: Seams::from(&manifest.seams),
        clips: clips.collect(),
        materials: materials.collect(),
        parts: parts.collect(),
        measured: measured.collect(),
        discrete: inspect_discrete(character),
        table_bytes: Some(table_bytes(character)),
        animation: Some(inspect_animation(character)),
        impostors: character.impostors().map(|record| ImpostorInspection {
            tile_px: record.tile_px,
            directions: [record.azimuth_count, record.elevation_count],
            clips: record.clip_count,
            poses_a_clip: record.pose_count,
            bytes: u64::from(record.color_byte_count) + u64::from(record.normal_byte_count),
        }),
        blocked: Some(Blocked { fixed: b.fixed, seam: b.seam, topology: b.topology, flip: b.flip, ended: b.ended }),
        warnings: manifest.warnings.clone(),
    }
}

/// The discrete levels that the bake stored, finest first.
pub(crate) fn inspect_discrete(character: &Unpacked<'_>) -> Vec<DiscreteInspection> {
    let manifest = character.manifest;
    let levels = manifest.discrete.iter().zip(character.discrete_levels());
    let inspect = |(discrete, level): (&ManifestDiscrete, &LevelRecord)| DiscreteInspection {
        name: discrete.name.clone(),
        target: LodTarget(discrete.target).words(),
        reached: discrete.reached,
        refitted: level.is_refit(),
        measured: inspect_measured(&discrete.measured, clip_name(manifest, &discrete.measured)),
    };
    levels.map(inspect).collect()
}

/// How a packed character's animation is stored.
pub(crate) fn inspect_animation(character: &Unpacked<'_>) -> AnimationInspection {
    let layout = character.contents.manifest.animation_layout;
    let sampled_frames = (0..character.clips.len()).map(|clip| character.sampled_frames(clip)).sum();
    AnimationInspection {
        storage: storage_name(layout, character.record.storage().unwrap_or_default()),
        error_m: character.record.storage_error_m,
        frames: character.clips.iter().map(|clip| clip.frame_count).sum(),
        sampled_frames,
        between_frames_m: None,
        between_frames_clip: None,
        bytes: character.animation_bytes(),
        papers_bytes: character.papers_animation_bytes(),
        vertex_texture_bytes: vertex_texture_bytes(character.record.vertex_count, sampled_frames),
    }
}

fn vertex_texture_bytes(vertex_count: u32, frames: u64) -> u64 {
    frames.saturating_mul(u64::from(vertex_count) * 8)
}

impl AnimationInspection {
    /// Of what a bake stores.
    pub(crate) fn of_bake(baked: &BakedCharacter) -> Self {
        let (animation, joint_count) = (&baked.animation, baked.raw.joints.len());
        let vertex_count = baked.order.levels.last().map_or(0, |full| full.vertex_count);
        Self {
            storage: animation.storage_name(),
            error_m: animation.error_m,
            frames: animation.clips.iter().map(|clip| clip.frame_count).sum(),
            sampled_frames: animation.sampled_frames.into(),
            between_frames_m: Some(animation.between.distance_m),
            between_frames_clip: Some(animation.between.clip.clone()),
            bytes: animation.bytes(joint_count),
            papers_bytes: animation.papers_bytes(joint_count),
            vertex_texture_bytes: vertex_texture_bytes(vertex_count, animation.sampled_frames.into()),
        }
    }

    /// In words.
    pub(crate) fn words(&self) -> String {
        let between = match (self.between_frames_m, &self.between_frames_clip) {
            (Some(distance_m), Some(clip)) if distance_m > 0.0 => {
                let clip = clip.escape_debug();
                format!("; between sampled frames up to {:.3} mm from the curves (clip {clip})", distance_m * 1e3)
            }
            _ => String::new(),
        };
        format!(
            "{}, {} of {} frames, {} bytes ({:.3} of the papers' layout, {:.3} of a texture of posed vertices), off by {:.3} mm at most from the sampled clips{between}",
            self.storage,
            grouped(self.frames),
            grouped(self.sampled_frames),
            grouped(self.bytes),
            self.bytes as f64 / self.papers_bytes.max(1) as f64,
            self.bytes as f64 / self.vertex_texture_bytes.max(1) as f64,
            self.error_m * 1e3,
        )
    }
}

/// The clip of a level's largest distance.
pub(crate) fn clip_name<'a>(manifest: &'a ManifestCharacter, level: &ManifestMeasured) -> Option<&'a str> {
    manifest.clips.get(level.max_clip as usize).map(|clip| clip.name.as_str())
}

/// `clip`: name of that of the largest distance.
pub(crate) fn inspect_measured(level: &ManifestMeasured, clip: Option<&str>) -> MeasuredInspection {
    MeasuredInspection {
        vertices: level.vertex_count,
        triangles: level.triangle_count,
        rms_m: level.rms_m,
        max_m: level.max_m,
        max_clip: clip.unwrap_or_default().to_owned(),
        max_frame: level.max_frame,
        bound_m: level.bound_m,
        bound_px: level.bound_px,
        uv_drift_p95_texels: level.uv_drift_p95_texels,
        normal_mean_deg: level.normal_mean_deg,
        poked_share: level.poked_share,
    }
}

fn table_bytes(character: &Unpacked<'_>) -> u64 {
    let bytes = |level: &LevelRecord| {
        let own = if level.is_refit() { u64::from(level.vertex_count) * size_of::<VertexRecord>() as u64 } else { 0 };
        u64::from(level.triangle_count) * 3 * u64::from(level.index_bytes) + own
    };
    character.quantized_levels().iter().chain(character.discrete_levels()).map(bytes).sum()
}

impl From<&ManifestSeams> for Seams {
    fn from(seams: &ManifestSeams) -> Self {
        Self {
            positions: seams.position_count,
            wedges: seams.wedge_count,
            seam_positions: seams.seam_position_count,
            fixed: seams.fixed_count,
            on_border: seams.border_count,
            companion: seams.companion_count,
            regular: seams.regular_count,
            odd: OddCounts::of_pack(seams),
        }
    }
}

impl From<&SeamReport> for Seams {
    fn from(seams: &SeamReport) -> Self {
        Self {
            positions: seams.position_count,
            wedges: seams.wedge_count,
            seam_positions: seams.seam_position_count,
            fixed: seams.fixed_count,
            on_border: seams.border_count,
            companion: seams.companion_count,
            regular: seams.regular_count,
            odd: OddCounts {
                degenerate_triangles: seams.degenerate_triangle_count,
                duplicate_triangles: seams.duplicate_triangle_count,
                coincident_triangles: seams.coincident_triangle_count,
                non_manifold_edges: seams.non_manifold_edge_count,
                non_manifold_positions: seams.non_manifold_position_count,
            },
        }
    }
}
