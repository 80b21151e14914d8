//! The results of the lines of a script.

use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One line that was carried out, or refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ScriptReply {
    /// Number of the line, from 1 up; empty lines are not counted.
    pub line: u32,
    /// Simulated time (s).
    pub at_s: f64,
    /// What was asked for, as in the script.
    #[serde(rename = "do")]
    pub action: String,
    /// Whether it was done.
    pub accepted: bool,
    /// Why not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<String>,
}

impl std::fmt::Display for ScriptReply {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { line, action, .. } = self;
        let at_s = self.at_s;
        match &self.reason {
            None => write!(f, "script line {line}, {action}, at {at_s:.3} s: done"),
            Some(why) => write!(
                f,
                "script line {line}, {action}, at {at_s:.3} s: refused: {why}"
            ),
        }
    }
}

/// The file with all results in the run directory `dir`.
fn path(dir: &Path) -> PathBuf {
    dir.join("script.json")
}

/// The results of the run in `dir`; none while there is no file.
pub fn load(dir: &Path) -> Vec<ScriptReply> {
    let text = std::fs::read(path(dir)).unwrap_or_default();
    serde_json::from_slice(&text).unwrap_or_default()
}

/// Writes `replies`; they can be read at any time.
///
/// # Errors
/// Returns errors of the file system.
pub fn save(replies: &[ScriptReply], dir: &Path) -> std::io::Result<()> {
    cell_model::draft::replace_unsynced(&path(dir), &serde_json::to_vec(replies)?, 0o644)
}
