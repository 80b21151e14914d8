//! The report of the recorder of a run.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

/// The recorded and the missing messages. The recorder writes the report into the run directory
/// when it ends, and as soon as an error occurs; the launcher reads it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RecordReport {
    /// Messages that were not recorded.
    pub gaps: u64,
    /// Bytes in the file of `--record`; of all parts, if the recorder was restarted.
    pub bytes: u64,
    /// Reason for which the file, or the flight recorder, is incomplete.
    pub error: Option<String>,
    /// Whether the files are closed.
    pub closed: bool,
    /// The file of `--record`, and the parts that later starts of the recorder wrote.
    #[serde(default)]
    pub files: Vec<PathBuf>,
}

impl RecordReport {
    /// Its file in the run directory `dir`.
    pub fn path(dir: &Path) -> PathBuf {
        dir.join("record.json")
    }

    /// The report of the run in `dir`; `None` while there is none.
    pub fn load(dir: &Path) -> Option<Self> {
        serde_json::from_slice(&std::fs::read(Self::path(dir)).ok()?).ok()
    }

    /// Writes the report; it can be read at any time.
    ///
    /// # Errors
    ///
    /// Returns errors of the file system.
    pub fn save(&self, dir: &Path) -> std::io::Result<()> {
        // The report is not synced: it is of no use after a power failure.
        cell_model::draft::replace_unsynced(&Self::path(dir), &serde_json::to_vec(self)?, 0o644)
    }
}
