//! What can be wrong with a file a person wrote.

use std::fmt;

use thiserror::Error;

/// A place in a file: `cells/reach.toml:12`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Location {
    /// The file as the person named it.
    pub file: String,
    /// Line from 1 up, where known.
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

    /// A line of a file; `None` where only the file is known.
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

/// Why a robot or a cell cannot be loaded. Every message names the file, what
/// is wrong there and what to do.
#[derive(Debug, Error)]
pub enum ModelError {
    /// A file is missing or unreadable.
    #[error("cannot read {file}: {reason}; {advice}")]
    Read {
        /// The file as named.
        file: String,
        /// The operating system's word, or what is known instead.
        reason: String,
        /// What to do.
        advice: String,
    },
    /// The file is not well formed.
    #[error("{place}: {message}")]
    Syntax {
        /// Where.
        place: Location,
        /// What the parser says.
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
    /// A value outside what is allowed.
    #[error("{place}: {key} is {value}; {allowed}")]
    Value {
        /// Where.
        place: Location,
        /// Key or item, with the name of its owner.
        key: String,
        /// The value found.
        value: String,
        /// What is allowed and what to do.
        allowed: String,
    },
    /// A name that leads nowhere.
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
        /// What the tree lacks.
        source: rmp::ChainError,
    },
}

impl ModelError {
    /// A value outside what is allowed.
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
