//! Why a pack was refused or not written, sorted by who is at fault.

use std::path::PathBuf;

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Where, what was found, what is allowed.
#[non_exhaustive]
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Reading or writing failed.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's word.
        source: std::io::Error,
    },
    /// The bytes are wrong.
    #[error("pack: {place}: found {found}, allowed {allowed}")]
    Format {
        /// Header, section table, section and record.
        place: String,
        /// Found.
        found: String,
        /// Allowed.
        allowed: String,
    },
    /// A version this reader does not know.
    #[error(
        "pack: format version {found}, this build reads versions {} to {supported}; bake the pack again",
        crate::PLAIN_VERSION
    )]
    Version {
        /// In the file.
        found: u32,
        /// [`crate::FORMAT_VERSION`].
        supported: u32,
    },
    /// A section's bytes do not match their checksum.
    #[error("pack: section {section}: checksum {found:08x}, the table says {expected:08x}; the file is damaged")]
    Checksum {
        /// Section name.
        section: String,
        /// Computed.
        found: u32,
        /// In the table.
        expected: u32,
    },
    /// Too big by our own rule.
    #[error("pack: {what}: found {found}, allowed {allowed}")]
    Limit {
        /// Of what.
        what: String,
        /// Found.
        found: u64,
        /// Allowed ([`crate::limits`]).
        allowed: u64,
    },
}
