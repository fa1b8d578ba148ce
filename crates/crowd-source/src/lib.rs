//! glTF and OBJ in, one validated [`RawCharacter`] out.
//!
//! Everything here treats the file as hostile: counts and sizes are checked against [`Limits`] and against the file's
//! own length before anything is allocated, and no URI may leave the asset's folder. What it leaves to others: sampling
//! clips (`crowd-anim`), seams and levels (`crowd-lod`), file layout (`crowd-pack`).

mod character;
mod error;
mod limits;

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
    let _ = (path, limits);
    unimplemented!("crowd-source: being written")
}
