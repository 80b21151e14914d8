//! Errors of recordings.

use std::path::{Path, PathBuf};

/// A recording that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// An error of the file system.
    #[error("{path}: {source}")]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// Reason given by the system.
        source: std::io::Error,
    },
    /// Bytes that cannot be decoded.
    #[error("{path}, at byte {offset}: {reason}")]
    Format {
        /// The file.
        path: PathBuf,
        /// Byte offset in the file.
        offset: u64,
        /// Description of the defect.
        reason: String,
    },
    /// The path has no recording.
    #[error(
        "{path}: {reason}; give a file made by `robocell record`, or the directory of a flight recorder"
    )]
    NoRecording {
        /// The file or directory.
        path: PathBuf,
        /// The missing part.
        reason: String,
    },
    /// A message that cannot be read.
    #[error("channel {channel}, tick {tick}: {reason}")]
    Message {
        /// Its channel.
        channel: String,
        /// Tick that caused it.
        tick: u64,
        /// Description of the defect.
        reason: String,
    },
    /// No state at or before the requested time.
    #[error(
        "no state of the world is recorded at or before {time_s:.3} s; there is {from_s:.3} s to {to_s:.3} s"
    )]
    NoState {
        /// The requested time (s).
        time_s: f64,
        /// Start of the recording (s).
        from_s: f64,
        /// End of it (s).
        to_s: f64,
    },
    /// The disk refused to write.
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
