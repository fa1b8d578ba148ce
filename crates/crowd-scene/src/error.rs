//! What can be wrong with a scene's file.

/// Result of this crate.
pub type Result<T> = std::result::Result<T, Error>;

/// Why a layout, a trajectory, a waypoint list or a camera path was refused.
#[non_exhaustive]
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A line of a text file is wrong.
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
    /// Something larger than a line is wrong: a database, a column, a polygon, the whole file.
    #[error("{place}: found {found}, expected {expected}{}", remedy_words(remedy))]
    Content {
        /// Where in the file.
        place: String,
        /// What was found there.
        found: String,
        /// What should be.
        expected: String,
        /// What the user can do; may be empty.
        remedy: &'static str,
    },
}

fn remedy_words(remedy: &str) -> String {
    if remedy.is_empty() { String::new() } else { format!("; {remedy}") }
}

impl Error {
    /// A [`Error::Content`] without a remedy.
    pub(crate) fn content(
        place: impl Into<String>,
        found: impl std::fmt::Display,
        expected: impl std::fmt::Display,
    ) -> Self {
        Self::Content { place: place.into(), found: found.to_string(), expected: expected.to_string(), remedy: "" }
    }

    /// The same error, with what the user can do.
    pub(crate) fn with_remedy(self, words: &'static str) -> Self {
        match self {
            Self::Content { place, found, expected, .. } => Self::Content { place, found, expected, remedy: words },
            other => other,
        }
    }
}
