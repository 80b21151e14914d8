//! Rows of many episodes: their content, the shard that runs each, the file that they are
//! appended to, the merge of the files of all shards, and reports.
//!
//! A row depends on its inputs alone: the same build with the same inputs and seed writes
//! the same bytes on every machine. Facts that are not the same, such as the host and the time
//! of an episode, go to a side file, `FILE.info`.
//!
//! [`charts`] draws numbers of rows and of recordings.

pub mod charts;
pub mod identity;
pub mod info;
pub mod merge;
pub mod report;
mod report_text;
pub mod row;
pub mod rows_file;
pub mod shard;
pub mod stats;

use std::path::PathBuf;

/// Why rows cannot be written or merged.
#[derive(Debug, thiserror::Error)]
pub enum EvaluationError {
    /// A file.
    #[error("{path}: {source}", path = path.display())]
    Io {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Another process writes it.
    #[error(
        "{path}: another process writes this file; wait until it ends, or name another file with \
         `--out`", path = path.display()
    )]
    InUse {
        /// The file.
        path: PathBuf,
    },
    /// It was begun by another command.
    #[error(
        "{path}: started with another {what} ({found}, now {wanted}); repeat the command that \
         started it, or name another file with `--out`", path = path.display()
    )]
    Other {
        /// The file.
        path: PathBuf,
        /// What differs.
        what: &'static str,
        /// What the file says.
        found: String,
        /// What the command says.
        wanted: String,
    },
    /// A line is no row.
    #[error("{path}:{line}: no row of an episode: {reason}", path = path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// Why.
        reason: String,
    },
    /// Files that are not the shards of one evaluation.
    #[error("{}", problems.join("\n"))]
    Merge {
        /// All that is wrong.
        problems: Vec<String>,
    },
}

impl EvaluationError {
    fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Io { path, source }
    }
}
