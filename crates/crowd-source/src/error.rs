//! Why a file was refused, sorted by who is at fault.

use std::path::PathBuf;

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// A refusal: where, what was found, what is allowed, what to do.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file could not be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// A file that the asset names could not be read.
    #[error("{path}: {place}: `{name}`: {source}")]
    NamedFile {
        /// The asset.
        path: PathBuf,
        /// What names the file: a buffer, an image, a material.
        place: String,
        /// Its name as the asset writes it, shortened.
        name: String,
        /// The system's word.
        source: std::io::Error,
    },
    /// The file is wrong.
    #[error("{path}: {place}: {problem}")]
    Format {
        /// The file.
        path: PathBuf,
        /// Mesh, primitive, accessor...
        place: String,
        /// What was found and what is allowed.
        problem: String,
    },
    /// The file is right, but needs something that crowdbake does not do.
    #[error("{path}: {place}: {feature} is not supported; {remedy}")]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// Where it is asked for.
        place: String,
        /// What.
        feature: String,
        /// What the user can do.
        remedy: String,
    },
    /// Too big by our own rule.
    #[error("{path}: {place}: found {found} {what}, allowed {allowed}")]
    Limit {
        /// The file.
        path: PathBuf,
        /// Where.
        place: String,
        /// Of what.
        what: &'static str,
        /// Count found.
        found: u64,
        /// Count allowed ([`crate::Limits`]).
        allowed: u64,
    },
}
