//! How a policy behind a socket is used in a run.

use std::collections::BTreeMap;
use std::fmt;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::ModelError;
use crate::{toml_text, user_file};

/// Whether the name of a policy is the address of a server.
pub fn is_address(policy: &str) -> bool {
    policy.contains("://")
}

/// Reason of an episode whose policy server was not reached.
pub const UNREACHABLE: &str = "policy_unreachable";

/// The use of a policy server; its address is the name of the policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PolicyServer {
    /// Simulated time from an observation to its actions (ms).
    pub latency_ms: u32,
    /// By name of an observation the key under which it is sent; empty for all observations
    /// under their own names.
    pub names: BTreeMap<String, String>,
    /// File that the answers are written to; of many episodes a directory of them.
    pub keep: Option<PathBuf>,
    /// File with answers, in place of a server; of many episodes a directory of them.
    pub answers: Option<PathBuf>,
    /// Fault of the observations.
    pub fault: Option<Fault>,
    /// Whether time does not wait for an answer.
    pub real_time: bool,
}

/// Reads a file of names, see [`PolicyServer::names`].
///
/// # Errors
/// [`ModelError`] for a file that cannot be read, and for a line that is not a name.
pub fn read_names(path: &Path) -> Result<BTreeMap<String, String>, ModelError> {
    let file = path.display().to_string();
    let text = user_file::read_text(path).map_err(|source| ModelError::Read {
        file: file.clone(),
        reason: source.to_string(),
        advice: "--names takes a file of lines \"agent_pos\" = \"observation/state\"".to_owned(),
    })?;
    toml_text::parse(&file, &text)
}

impl PolicyServer {
    /// For the episode with this name, of many.
    #[must_use]
    pub fn of_episode(&self, name: &str) -> Self {
        let file = |dir: &PathBuf| dir.join(format!("{name}.answers.jsonl"));
        let is_file = |path: &&PathBuf| path.is_file();
        let one = self.answers.as_ref().filter(is_file);
        Self {
            keep: self.keep.as_ref().map(file),
            answers: one.cloned().or_else(|| self.answers.as_ref().map(file)),
            ..self.clone()
        }
    }
}

/// Use of a policy server in a run.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ServerReport {
    /// Simulated time from an observation to its actions (ms).
    pub latency_ms: u32,
    /// Fault of the observations, in the form of `--fault`; missing without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// Answers that were asked for.
    pub requests: u64,
    /// Steps in which an arm held or repeated the last action of an answer.
    pub stale_steps: u64,
    /// Hash of all answers, 16 hexadecimal digits.
    pub answers: String,
}

/// A fault of the observations that a policy server gets, for some ticks.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Fault {
    /// What happens.
    pub kind: FaultKind,
    /// Ticks in which it does.
    pub ticks: Range<u64>,
}

/// What happens to an observation.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// It is not delivered: the one before is sent again.
    Drop,
    /// It is older by this (ms).
    Late(u64),
    /// A camera is displaced in the frame in which its pose is given (m).
    Move {
        /// Name of the camera.
        camera: String,
        /// The displacement.
        by_m: [f64; 3],
    },
}

// Displacements are finite.
impl Eq for FaultKind {}

/// Period of the observations (ms).
const STEP_MS: u64 = 50;

/// Longest delay of an observation (ms): all states of that time are kept.
pub const MAX_LATE_MS: u64 = 5000;

impl FromStr for Fault {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let refused = || {
            format!(
                "{text:?} is not a fault; write drop@FROM..TO, late:MS@FROM..TO with a multiple of \
                 {STEP_MS} up to {MAX_LATE_MS}, or move:CAMERA:X,Y,Z@FROM..TO with a displacement in m; FROM and TO are ticks of 1 ms"
            )
        };
        let parsed = || {
            let (kind, ticks) = text.split_once('@')?;
            let (from, to) = ticks.split_once("..")?;
            let ticks = from.parse().ok()?..to.parse().ok()?;
            let kind = kind_of(kind)?;
            (!ticks.is_empty()).then_some(Self { kind, ticks })
        };
        parsed().ok_or_else(refused)
    }
}

fn kind_of(text: &str) -> Option<FaultKind> {
    if text == "drop" {
        return Some(FaultKind::Drop);
    }
    if let Some(ms) = text.strip_prefix("late:") {
        let ms = ms.parse().ok();
        // Observations are made once in a period: only whole periods of delay exist.
        let ms = ms.filter(|ms: &u64| (1..=MAX_LATE_MS).contains(ms) && ms.is_multiple_of(STEP_MS));
        return ms.map(FaultKind::Late);
    }
    let (camera, by_m) = text.strip_prefix("move:")?.split_once(':')?;
    let by_m = by_m.split(',').map(|number| number.parse::<f64>().ok());
    let by_m: Vec<f64> = by_m.collect::<Option<_>>()?;
    Some(FaultKind::Move {
        camera: camera.to_owned(),
        by_m: by_m.try_into().ok().filter(|by_m: &[f64; 3]| {
            // Farther away nothing of a cell is seen.
            by_m.iter().all(|part| part.abs() <= 10.0)
        })?,
    })
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            FaultKind::Drop => f.write_str("drop")?,
            FaultKind::Late(ms) => write!(f, "late:{ms}")?,
            FaultKind::Move { camera, by_m } => {
                let [x, y, z] = by_m;
                write!(f, "move:{camera}:{x},{y},{z}")?;
            }
        }
        write!(f, "@{}..{}", self.ticks.start, self.ticks.end)
    }
}

impl TryFrom<String> for Fault {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Fault> for String {
    fn from(fault: Fault) -> Self {
        fault.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::Fault;

    #[test]
    fn faults_are_read_as_they_are_shown() {
        for text in [
            "drop@2000..4000",
            "late:150@0..90000",
            "move:wrist:0.02,0,-0.005@0..500",
        ] {
            assert_eq!(text.parse::<Fault>().unwrap().to_string(), text);
        }
        for bad in [
            "drop",
            "drop@5..5",
            "drop@5..",
            "late@1..2",
            "late:0@1..2",
            "late:5050@1..2",
            "late:20@1..2",
            "move:wrist:0.02@0..5",
            "move:wrist:nan,0,0@0..5",
            "freeze@1..2",
        ] {
            let error = bad.parse::<Fault>().unwrap_err();
            assert!(error.contains("drop@FROM..TO"), "{error}");
        }
    }
}
