//! Errors in files that a person wrote.

use std::fmt;

use thiserror::Error;

/// A place in a file, such as `cells/reach.toml:12`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// Name of the file as the person gave it.
    pub file: String,
    /// Line from 1, if known.
    pub line: Option<usize>,
}

impl Location {
    /// A whole file.
    pub fn file(file: &str) -> Self {
        Self {
            file: file.to_owned(),
            line: None,
        }
    }

    /// A line of a file; `None` if only the file is known.
    pub fn line(file: &str, line: Option<usize>) -> Self {
        Self {
            file: file.to_owned(),
            line,
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "{}:{line}", self.file),
            None => f.write_str(&self.file),
        }
    }
}

/// Reason for which a robot or a cell cannot be loaded. Every message names the file, the
/// problem and advice.
#[derive(Debug, Error)]
pub enum ModelError {
    /// A file is missing or unreadable.
    #[error("cannot read {file}: {reason}; {advice}")]
    Read {
        /// The file as named.
        file: String,
        /// Message of the operating system, or another reason.
        reason: String,
        /// Advice.
        advice: String,
    },
    /// The file is not well formed.
    #[error("{place}: {message}")]
    Syntax {
        /// Where.
        place: Location,
        /// Message of the parser.
        message: String,
    },
    /// An unknown key.
    #[error("{place}: unknown key '{key}'; {advice}")]
    UnknownKey {
        /// Where.
        place: Location,
        /// The key found.
        key: String,
        /// The nearest known key, or all of them.
        advice: String,
    },
    /// A value outside of the allowed ones.
    #[error("{place}: {key} is {value}; {allowed}")]
    Value {
        /// Where.
        place: Location,
        /// Key or item, with the name of its owner.
        key: String,
        /// The value found.
        value: String,
        /// The allowed values, and advice.
        allowed: String,
    },
    /// An unknown name.
    #[error("unknown {what} '{name}'; {advice}")]
    UnknownName {
        /// demo, robot, frame...
        what: &'static str,
        /// The name given.
        name: String,
        /// The nearest known name, or all of them.
        advice: String,
    },
    /// The kinematic tree is refused.
    #[error("{place}: {source}")]
    Chain {
        /// Where.
        place: Location,
        /// Problem of the tree.
        source: rmp::ChainError,
    },
}

impl ModelError {
    /// A value outside of the allowed ones.
    pub(crate) fn value(
        place: Location,
        key: impl Into<String>,
        value: impl fmt::Display,
        allowed: impl Into<String>,
    ) -> Self {
        Self::Value {
            place,
            key: key.into(),
            value: value.to_string(),
            allowed: allowed.into(),
        }
    }
}
