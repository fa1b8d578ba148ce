//! Where the real characters are.

use std::path::{Path, PathBuf};

use crowd_source::{Error, Limits, RawCharacter, load_character};

/// The assets folder: `CROWD_ASSETS`, or `../shared/assets` beside the workspace.
pub fn folder() -> PathBuf {
    match std::env::var_os("CROWD_ASSETS").filter(|v| !v.is_empty()) {
        Some(named) => named.into(),
        None => Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/assets"),
    }
}

/// All `.glb`, `.gltf` and `.obj` files below a folder, sorted.
pub fn files_below(below: &str) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder().join(below)];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).expect("the assets folder is readable") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "glb" || e == "gltf" || e == "obj") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

pub fn try_load(name: &str) -> Result<RawCharacter, Error> {
    load_character(&folder().join(name), &Limits::default())
}

#[track_caller]
pub fn load(name: &str) -> RawCharacter {
    try_load(name).unwrap_or_else(|e| panic!("{e}"))
}
