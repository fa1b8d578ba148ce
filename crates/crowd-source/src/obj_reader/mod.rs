//! OBJ and MTL in, one static character out: one node, one joint, every vertex on it.
//!
//! The text is checked and rewritten first (`clean`), so that tobj only sees what it can take; tobj's separate position,
//! texture and normal indices then become one universal index (Dong 2019 §5.2, Algorithm 1).

mod clean;
mod polygons;
mod surfaces;

use std::cell::RefCell;
use std::collections::HashMap;
use std::path::PathBuf;

use crate::folder::Folder;
use crate::names::{name_or, shorten};
use crate::part::{
    DEGENERATE, NO_UV, PartMesh, all_degenerate, append_part, complete_normals, is_too_far, is_uv, too_far,
    weld_vertices,
};
use crate::refusal::{Asset, Warnings};
use crate::turned_surfaces::{TURNED, count_turned};
use crate::{RawCharacter, RawCredits, RawJoint, RawMesh, RawNode, Result};
use polygons::triangulate_polygon;
use surfaces::SurfaceTable;

/// The libraries that an `.obj` names and the textures that these name, where they are there.
pub(crate) fn list_files(asset: Asset<'_>, folder: &Folder<'_>, bytes: &[u8]) -> Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for line in clean::decode_text(asset, bytes)?.lines() {
        let Some(("mtllib", name)) = line.trim().split_once(char::is_whitespace) else { continue };
        let Some(library) = folder.locate_path(name.trim()) else { continue };
        files.push(library);
        let Ok(text) = folder.read_path("mtllib", name.trim()).and_then(|text| clean::decode_text(asset, &text)) else {
            continue;
        };
        files.extend(surfaces::list_textures(&text).filter_map(|texture| folder.locate_path(texture)));
    }
    Ok(files)
}

/// Reads an `.obj`; its `mtllib` and textures come from the same folder.
pub(crate) fn read_obj(asset: Asset<'_>, name: String, bytes: &[u8]) -> Result<RawCharacter> {
    let mut warnings = Warnings::default();
    let folder = Folder::of(asset)?;
    let text = clean::decode_text(asset, bytes)?;
    let cleaned = clean::clean_obj(asset, &text, &mut warnings)?;
    let (models, materials) = parse_with_tobj(asset, &folder, &cleaned.text, &mut warnings)?;

    let mut surfaces = SurfaceTable::new(asset, &folder, &materials);
    let mut mesh = RawMesh::default();
    for (model_name, material, meshes) in group_models(&models) {
        let place = format!("object `{}`", shorten(model_name));
        let mut part = PartMesh::default();
        let mut repaired_uvs = 0;
        for model in meshes {
            repaired_uvs += unify_indices(asset, &place, &cleaned, model, &mut part)?;
        }
        warnings.add("uvs-repaired", &place, repaired_uvs, NO_UV);
        if part.triangles.is_empty() {
            continue;
        }
        let has_normals = !part.normals.is_empty();
        let flat = part.normals.is_empty() && cleaned.is_faceted;
        let repaired = complete_normals(&mut part);
        let message = "normals without a direction were computed from the triangles around them";
        warnings.add("normals-repaired", &place, repaired, message);
        part.joints = vec![[0; 4]; part.positions.len()];
        part.weights = vec![[1.0, 0.0, 0.0, 0.0]; part.positions.len()];
        let degenerate = weld_vertices(&mut part);
        warnings.add("degenerate-triangles-dropped", &place, degenerate, DEGENERATE);
        if part.triangles.is_empty() {
            continue;
        }
        let material = surfaces.index(material, flat, &mut warnings)?;
        if has_normals {
            warnings.add("turned-surfaces", &place, count_turned(&part), TURNED);
        }
        append_part(&mut mesh, part, name_or(Some(model_name), || "object".to_owned()), material, true);
    }
    let found = models.iter().map(|model| count_triangles(&model.mesh)).sum();
    if mesh.triangles.is_empty() && found > 0 {
        return Err(asset.format("file", all_degenerate(found)));
    }
    if mesh.triangles.is_empty() {
        return Err(asset.format("file", "no faces; a character needs at least one triangle"));
    }
    let root = RawNode {
        name: name.clone(),
        parent: None,
        translation: [0.0; 3],
        rotation: [0.0, 0.0, 0.0, 1.0],
        scale: [1.0; 3],
    };
    let inverse_bind = glam::Mat4::IDENTITY.to_cols_array();
    Ok(RawCharacter {
        name,
        skin_name: String::new(),
        credits: RawCredits::default(),
        mesh,
        materials: surfaces.materials,
        images: surfaces.images,
        finish_images: surfaces.finish_images,
        nodes: vec![root],
        joints: vec![RawJoint { node: 0, inverse_bind }],
        rig: crate::RawRig::default(),
        clips: Vec::new(),
        warnings: warnings.into_list(),
    })
}

fn parse_with_tobj(
    asset: Asset<'_>,
    folder: &Folder<'_>,
    text: &str,
    warnings: &mut Warnings,
) -> Result<(Vec<tobj::Model>, Vec<tobj::Material>)> {
    let options =
        tobj::LoadOptions { single_index: false, triangulate: false, ignore_points: true, ignore_lines: true };
    let refused = RefCell::new(None);
    let warnings = RefCell::new(warnings);
    let read_library = |library: &std::path::Path| {
        let name = library.to_string_lossy();
        match surfaces::read_library(asset, folder, &name, &mut warnings.borrow_mut()) {
            Ok(text) => tobj::load_mtl_buf(&mut text.as_bytes()),
            Err(error) => {
                refused.borrow_mut().get_or_insert(error);
                Err(tobj::LoadError::OpenFileFailed)
            }
        }
    };
    let loaded = tobj::load_obj_buf(&mut text.as_bytes(), &options, read_library);
    if let Some(error) = refused.into_inner() {
        return Err(error);
    }
    let (models, materials) = loaded.map_err(|e| asset.format("file", format!("not an OBJ file: {e}")))?;
    let materials = materials.map_err(|e| asset.format("material library", e.to_string()))?;
    Ok((models, materials))
}

fn count_triangles(mesh: &tobj::Mesh) -> u64 {
    match mesh.face_arities.as_slice() {
        [] => mesh.indices.len() as u64 / 3,
        arities => arities.iter().map(|&arity| u64::from(arity).saturating_sub(2)).sum(),
    }
}

/// Models of one name and material together, in the order in which they begin.
fn group_models(models: &[tobj::Model]) -> Vec<(&str, Option<usize>, Vec<&tobj::Mesh>)> {
    let mut groups: Vec<(&str, Option<usize>, Vec<&tobj::Mesh>)> = Vec::new();
    let mut known: HashMap<(&str, Option<usize>), usize> = HashMap::new();
    for model in models {
        let key = (model.name.as_str(), model.mesh.material_id);
        let group = *known.entry(key).or_insert_with(|| {
            groups.push((key.0, key.1, Vec::new()));
            groups.len() - 1
        });
        groups[group].2.push(&model.mesh);
    }
    groups
}

/// Dong 2019 §5.2, Algorithm 1: a vertex for every combination of position and texture point that faces use (and normal,
/// which the paper computes later), so that one index serves all attributes. Departs: a hash map finds the
/// combinations, where the paper searches. Returns how many vertices have no texture coordinates that can be.
fn unify_indices(
    asset: Asset<'_>,
    place: &str,
    cleaned: &clean::Cleaned,
    model: &tobj::Mesh,
    part: &mut PartMesh,
) -> Result<u64> {
    let mut universal: HashMap<[u32; 3], u32> = HashMap::with_capacity(model.positions.len() / 3);
    let mut corners = Vec::with_capacity(model.indices.len());
    let mut repaired_uvs = 0;
    for (at, &position) in model.indices.iter().enumerate() {
        let texture = model.texcoord_indices.get(at).copied();
        let normal = model.normal_indices.get(at).copied();
        let key = [position, texture.unwrap_or(0), normal.unwrap_or(0)];
        let fresh = part.positions.len() as u32;
        let vertex = *universal.entry(key).or_insert(fresh);
        if vertex == fresh {
            let point: [f32; 3] = numbers(&model.positions, position);
            if point.iter().any(|c| !c.is_finite()) {
                return Err(asset.format("file", format!("a vertex lies at {point:?}; positions are finite")));
            }
            if is_too_far(&point) {
                return Err(asset.format(place, format!("a vertex {}", too_far(&point))));
            }
            part.positions.push(point);
            let [u, v] = texture.map_or([0.0; 2], |t| numbers(&model.texcoords, t));
            // OBJ counts v upwards, glTF downwards.
            let uv = [u, 1.0 - v];
            repaired_uvs += u64::from(!is_uv(&uv));
            part.uvs.push(if is_uv(&uv) { uv } else { [0.0; 2] });
            if cleaned.has_normals {
                part.normals.push(normal.map_or([0.0; 3], |n| numbers(&model.normals, n)));
            }
            part.colors.push(match model.vertex_color.is_empty() {
                true => [255; 4],
                false => {
                    let [r, g, b]: [f32; 3] = numbers(&model.vertex_color, position);
                    [r, g, b, 1.0].map(|c| (c.clamp(0.0, 1.0) * 255.0 + 0.5) as u8)
                }
            });
        }
        corners.push(vertex);
    }
    let mut rest = &corners[..];
    // tobj leaves the arities out when all faces are triangles.
    let arities = model.face_arities.iter().map(|a| *a as usize).chain(std::iter::repeat(3));
    for arity in arities {
        if rest.len() < arity.max(1) {
            break;
        }
        let (face, after) = rest.split_at(arity);
        triangulate_polygon(&part.positions, face, &mut part.triangles);
        rest = after;
    }
    Ok(repaired_uvs)
}

fn numbers<const N: usize>(list: &[f32], index: u32) -> [f32; N] {
    std::array::from_fn(|i| list.get(index as usize * N + i).copied().unwrap_or(0.0))
}
