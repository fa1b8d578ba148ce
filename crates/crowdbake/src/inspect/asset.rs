//! What an asset is before it is baked.

use super::{CharacterInspection, ClipInspection, Inspection, MaterialInspection, PartInspection, Seams};
use crate::bake::{lod_mesh, warning_sentence};
use crate::error::{BakeError, Cause, Step};
use crate::report::SCHEMA_VERSION;
use crate::views;
use crowd_lod::{Appearance, SeamReport};
use crowd_source::{Limits, RawCharacter};
use std::path::Path;

/// Looks into an asset without baking it.
///
/// # Errors
/// The asset is refused.
pub fn inspect_asset(path: &Path) -> Result<Inspection, BakeError> {
    if path.is_dir() {
        let source = std::io::Error::new(std::io::ErrorKind::IsADirectory, "is a folder, a pack or an asset is needed");
        return Err(BakeError::whole(Step::Read, Cause::Input { path: path.to_owned(), source }));
    }
    let name = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let raw = crowd_source::load_character(path, &Limits::default())
        .map_err(|error| BakeError::of(Step::Load, &name, error))?;
    let seams = classify(&raw).map_err(|error| BakeError::of(Step::Simplify, &name, error))?;
    let triangles = raw.mesh.triangles.len();
    if seams.degenerate_triangle_count as usize == triangles {
        return Err(BakeError::of(Step::Simplify, &name, Cause::OnlyDegenerate { triangles }));
    }
    Ok(Inspection {
        schema_version: SCHEMA_VERSION,
        kind: "asset",
        file: path.to_string_lossy().into_owned(),
        bytes: std::fs::metadata(path).map(|file| file.len()).unwrap_or_default(),
        generator: None,
        animation_layout: None,
        images: raw.images.len(),
        image_bytes: raw.images.iter().map(|image| image.bytes.len() as u64).sum(),
        characters: vec![inspect_raw(&raw, &seams, path)],
    })
}

/// Seams and classes of a raw character.
fn classify(raw: &RawCharacter) -> Result<SeamReport, crowd_lod::Error> {
    let mesh = views::quantize(&raw.mesh);
    let triangle_materials = views::triangle_materials(&raw.mesh);
    crowd_lod::classify(&lod_mesh(raw, &mesh, &triangle_materials, Appearance::default()))
}

fn inspect_raw(raw: &RawCharacter, seams: &SeamReport, path: &Path) -> CharacterInspection {
    let clips = raw.clips.iter().map(|clip| ClipInspection {
        name: clip.name.clone(),
        duration_s: views::clip_end_s(clip),
        frames: None,
        tracks: clip.tracks.len(),
        ground_speed_m_s: None,
        loop_gap_m: None,
        contacts: None,
        slide_m_s: None,
        rooted_slide_m_s: None,
    });
    let materials = raw.materials.iter().map(|material| MaterialInspection {
        name: material.name.clone(),
        base_color: material.base_color,
        texture: material.texture.map(|texture| {
            let image = &raw.images[texture.image as usize];
            [image.width, image.height]
        }),
        alpha_cutoff: material.alpha_cutoff.unwrap_or(0.0),
    });
    let parts = raw.mesh.parts.iter().map(|part| PartInspection {
        name: part.name.clone(),
        triangles: part.triangle_count,
        rigid: part.rigid,
    });
    CharacterInspection {
        name: raw.name.clone(),
        source: path.file_name().map(|file| file.to_string_lossy().into_owned()).unwrap_or_default(),
        copyright: Some(raw.credits.copyright.clone()).filter(|line| !line.is_empty()),
        vertices: seams.vertex_count,
        triangles: raw.mesh.triangles.len() as u32,
        coarsest_vertices: None,
        coarsest_triangles: None,
        levels: None,
        criteria: None,
        height_m: None,
        radius_m: None,
        joints: raw.joints.len(),
        seams: Seams::from(seams),
        clips: clips.collect(),
        materials: materials.collect(),
        parts: parts.collect(),
        measured: Vec::new(),
        discrete: Vec::new(),
        table_bytes: None,
        animation: None,
        impostors: None,
        blocked: None,
        warnings: raw.warnings.iter().map(warning_sentence).collect(),
    }
}
