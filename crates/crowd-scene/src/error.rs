//! What can be wrong with a text file.

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a layout or a camera path was refused.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// The file is wrong.
    #[error("line {line}: found {found}, expected {expected}")]
    Format {
        /// Counted from 1.
        line: usize,
        /// What stands there, shortened.
        found: String,
        /// What should.
        expected: String,
    },
    /// The file is too long by our rule.
    #[error("line {line}: more than {allowed} entries")]
    Limit {
        /// Counted from 1.
        line: usize,
        /// Largest count of entries.
        allowed: usize,
    },
}
