//! glTF and OBJ in, one validated [`RawCharacter`] out.
//!
//! Everything here treats the file as hostile: counts and sizes are checked against [`Limits`] and against the file's
//! own length before anything is allocated, and no URI may leave the asset's folder. What it leaves to others: sampling
//! clips (`crowd-anim`), seams and levels (`crowd-lod`), file layout (`crowd-pack`).

mod character;
mod error;
mod finish;
mod folder;
mod gltf_reader;
mod image_header;
mod limits;
mod named_files;
mod names;
mod obj_reader;
mod part;
mod refusal;
mod turned_surfaces;

pub use character::*;
pub use error::{Error, Result};
pub use finish::{RawBase, RawFinish};
pub use limits::Limits;
pub use named_files::named_files;

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
    // An unknown kind of file is refused unread.
    kind_of_file(asset)?;
    read_character(path, &folder::read_named_file(asset)?, limits)
}

/// Like [`load_character`], for the bytes of a file that is in memory already (an archive, a fuzzer).
///
/// `path` names the character, tells the kind of file by its extension, and stands in messages; files that the asset
/// names are read from the path's folder, which must exist.
///
/// # Errors
/// As [`load_character`].
pub fn read_character(path: &Path, bytes: &[u8], limits: &Limits) -> Result<RawCharacter> {
    let asset = refusal::Asset { path, limits };
    let stem = path.file_stem().map(|stem| stem.to_string_lossy());
    let name = names::name_or(stem.as_deref(), || "character".to_owned());
    match kind_of_file(asset)? {
        FileKind::Gltf => gltf_reader::read_gltf(asset, name, bytes),
        FileKind::Obj => obj_reader::read_obj(asset, name, bytes),
    }
}

enum FileKind {
    Gltf,
    Obj,
}

fn kind_of_file(asset: refusal::Asset<'_>) -> Result<FileKind> {
    let extension = asset.path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "glb" | "gltf" => Ok(FileKind::Gltf),
        "obj" => Ok(FileKind::Obj),
        _ => Err(asset.unsupported("file name", format!("the extension `.{extension}`"), "give a .glb, .gltf or .obj")),
    }
}
