//! The processes of a run, for programs that have to end them if the launcher cannot.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// One process of a run. The pid alone may belong to another process by now.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ChildId {
    /// Its process id.
    pub pid: u32,
    /// Its start in clock ticks since boot.
    pub started: u64,
}

impl ChildId {
    /// The file with all processes in the run directory `dir`: an array.
    pub fn path(dir: &Path) -> PathBuf {
        dir.join("children.json")
    }

    /// The processes listed in `dir`; none if the file cannot be read.
    pub fn all(dir: &Path) -> Vec<Self> {
        // A run that failed before its first process has no file, and nothing to end.
        let text = std::fs::read(Self::path(dir)).unwrap_or_default();
        serde_json::from_slice(&text).unwrap_or_default()
    }
}
