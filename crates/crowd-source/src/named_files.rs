//! Which files an asset names, for callers that write files beside it. What is in them is left to the readers.

use std::path::{Path, PathBuf};

use crate::folder::{Folder, read_named_file};
use crate::refusal::Asset;
use crate::{FileKind, Limits, Result, gltf_reader, kind_of_file, obj_reader};

/// The files that an asset names and that are there: buffers and images of a glTF, material libraries and textures of an
/// OBJ. Canonical paths, all in the asset's folder or below it.
///
/// Reads the asset itself but no geometry. Never fails: an asset that is refused before it names a file names none.
pub fn named_files(path: &Path) -> Vec<PathBuf> {
    list(Asset { path, limits: &Limits::default() }).unwrap_or_default()
}

fn list(asset: Asset<'_>) -> Result<Vec<PathBuf>> {
    let kind = kind_of_file(asset)?;
    let bytes = read_named_file(asset)?;
    let folder = Folder::of(asset)?;
    match kind {
        FileKind::Gltf => {
            let uris = gltf_reader::list_uris(asset, &bytes)?;
            Ok(uris.iter().filter_map(|uri| folder.locate_uri(uri)).collect())
        }
        FileKind::Obj => obj_reader::list_files(asset, &folder, &bytes),
    }
}
