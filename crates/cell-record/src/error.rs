//! What goes wrong with recordings.

use std::path::{Path, PathBuf};

/// A recording that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file system said no.
    #[error("{path}: {source}")]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Bytes that make no sense.
    #[error("{path}, at byte {offset}: {reason}")]
    Format {
        /// The file.
        path: PathBuf,
        /// Where in it.
        offset: u64,
        /// What is wrong.
        reason: String,
    },
    /// Nothing recorded there.
    #[error(
        "{path}: {reason}; give a file made by `robocell record`, or the directory of a flight recorder"
    )]
    NoRecording {
        /// The file or directory.
        path: PathBuf,
        /// What is missing.
        reason: String,
    },
    /// A message that cannot be read.
    #[error("channel {channel}, tick {tick}: {reason}")]
    Message {
        /// Its channel.
        channel: String,
        /// Tick that caused it.
        tick: u64,
        /// What is wrong.
        reason: String,
    },
    /// No state there.
    #[error(
        "no state of the world is recorded at or before {time_s:.3} s; there is {from_s:.3} s to {to_s:.3} s"
    )]
    NoState {
        /// The time asked for (s).
        time_s: f64,
        /// Begin of what is recorded (s).
        from_s: f64,
        /// End of it (s).
        to_s: f64,
    },
    /// The disk did not take it.
    #[error("the disk does not take it: {0}")]
    Write(String),
}

impl RecordError {
    pub(crate) fn io(path: &Path, source: std::io::Error) -> Self {
        Self::Io {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn format(path: &Path, offset: u64, reason: impl Into<String>) -> Self {
        Self::Format {
            path: path.to_owned(),
            offset,
            reason: reason.into(),
        }
    }

    #[expect(clippy::needless_pass_by_value, reason = "as `map_err` hands it over")]
    pub(crate) fn write(source: std::io::Error) -> Self {
        Self::Write(source.to_string())
    }
}
