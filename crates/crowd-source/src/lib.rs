//! glTF and OBJ in, one validated [`RawCharacter`] out.
//!
//! Everything here treats the file as hostile: counts and sizes are checked against [`Limits`] and against the file's
//! own length before anything is allocated, and no URI may leave the asset's folder. What it leaves to others: sampling
//! clips (`crowd-anim`), seams and levels (`crowd-lod`), file layout (`crowd-pack`).

mod character;
mod error;
mod folder;
mod gltf_reader;
mod image_header;
mod limits;
mod obj_reader;
mod part;
mod refusal;

pub use character::*;
pub use error::{Error, Result};
pub use limits::Limits;

use std::path::Path;

/// Reads one character from a `.glb`, `.gltf` or `.obj` file.
///
/// All meshes of the default scene become one character: their vertices are brought into one common bind space (see
/// [`RawJoint`]), meshes under plain nodes become rigidly skinned. `limits` bounds what may be allocated.
///
/// # Errors
/// [`Error`] names the file, the place in it, what was found and what is allowed.
pub fn load_character(path: &Path, limits: &Limits) -> Result<RawCharacter> {
    let asset = refusal::Asset { path, limits };
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = stem.filter(|stem| !stem.is_empty()).unwrap_or_else(|| "character".to_owned());
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "glb" | "gltf" => gltf_reader::read_gltf(asset, name, &folder::read_named_file(asset)?),
        "obj" => obj_reader::read_obj(asset, name, &folder::read_named_file(asset)?),
        _ => Err(asset.unsupported("file name", format!("the extension `.{extension}`"), "give a .glb, .gltf or .obj")),
    }
}
