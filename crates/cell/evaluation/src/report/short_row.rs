//! The part of a row that a report needs.

use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

use cell_model::user_file::{self, UserFile};
use serde::Deserialize;
use serde_json::Number;

use crate::EvaluationError;
use crate::row::{Key, RowOutcome};

/// What a report needs of a row.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Short {
    pub(super) demo: String,
    pub(super) policy: String,
    pub(super) seed: u64,
    #[serde(default)]
    pub(super) variant: u32,
    #[serde(default)]
    pub(super) set: BTreeMap<String, Number>,
    #[serde(default)]
    pub(super) latency_ms: Option<u32>,
    #[serde(default)]
    pub(super) fault: Option<String>,
    #[serde(default)]
    pub(super) drawn: BTreeMap<String, Number>,
    pub(super) outcome: RowOutcome,
    pub(super) reason: Option<String>,
    #[serde(default)]
    pub(super) message: Option<String>,
    pub(super) sim_time_s: f64,
    pub(super) drops: u32,
    pub(super) resyncs: u32,
    pub(super) aborts: u32,
    pub(super) limit_violations: u64,
    pub(super) state_hash: String,
}

impl Short {
    pub(super) fn key(&self) -> Key {
        Key {
            seed: self.seed,
            variant: self.variant,
        }
    }

    pub(super) fn is_done(&self) -> bool {
        self.outcome == RowOutcome::Done
    }

    /// Why it did not end done.
    pub(super) fn reason(&self) -> String {
        let outcome = match self.outcome {
            RowOutcome::Timeout => "timeout",
            RowOutcome::Error => "error",
            _ => "failed",
        };
        let reason = self.reason.as_ref();
        reason.map_or_else(|| outcome.to_owned(), |why| format!("{outcome}: {why}"))
    }
}

/// Reads the rows of a file, of which there is at least one.
pub(super) fn read(path: &Path) -> Result<Vec<Short>, EvaluationError> {
    let file = UserFile::open(path).map_err(EvaluationError::io(path))?;
    let (mut file, mut text) = (BufReader::new(file), String::new());
    let mut rows = Vec::new();
    while user_file::read_line(&mut file, &mut text).map_err(EvaluationError::io(path))? > 0 {
        let row = serde_json::from_str(&text).map_err(|error| EvaluationError::Line {
            path: path.to_owned(),
            line: rows.len() as u64 + 1,
            reason: error.to_string(),
        })?;
        rows.push(row);
    }
    if rows.is_empty() {
        return Err(EvaluationError::Line {
            path: path.to_owned(),
            line: 1,
            reason: "the file is empty".to_owned(),
        });
    }
    Ok(rows)
}
