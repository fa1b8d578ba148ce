//! Where things lie, seen from this package.

use std::path::PathBuf;

/// The repository's root.
pub fn repository() -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/.."))
}

/// The fixtures made by the project.
pub fn fixtures() -> PathBuf {
    repository().join("fixtures")
}

/// Characters made by others: `CROWD_ASSETS`, or `../shared/assets` beside the repository. Tests that need them are ignored
/// without (`cfg(crowd_assets)`, see `build.rs`).
pub fn assets() -> PathBuf {
    match std::env::var_os("CROWD_ASSETS").filter(|folder| !folder.is_empty()) {
        Some(folder) => PathBuf::from(folder),
        None => repository().join("../shared/assets"),
    }
}
