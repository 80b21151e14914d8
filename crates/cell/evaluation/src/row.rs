//! One episode.

use std::collections::BTreeMap;
use std::fmt;

use cell_model::cells::setting::by_key;
use cell_model::cells::sweep::Case;
use cell_run::summary::{RunOutcome, RunSummary};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Number;

use crate::identity::Identity;

/// How an episode ended.
#[derive(
    Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "snake_case")]
pub enum RowOutcome {
    /// The task finished.
    Done,
    /// The task gave up; see `reason`.
    Failed,
    /// The time limit came first.
    Timeout,
    /// The program could not finish the episode; see `reason`.
    Error,
}

/// Which episode of an evaluation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// Its seed.
    pub seed: u64,
    /// See [`Row::variant`].
    pub variant: u32,
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.variant {
            0 => write!(f, "seed {}", self.seed),
            variant => write!(f, "seed {}, variant {variant}", self.seed),
        }
    }
}

/// One episode; the keys and their order are a contract.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Row {
    /// Name of the demo.
    pub demo: String,
    /// Name of the policy.
    pub policy: String,
    /// Name of the build.
    pub build: String,
    /// Hash of the inputs.
    pub inputs: String,
    /// Seed of the episode.
    pub seed: u64,
    /// Which combination of the values of `--set`, from 1; not there without.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub variant: u32,
    /// The values of that combination, by the keys of the cell file.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, Number>,
    /// What was drawn for the seed, with `--vary`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub drawn: BTreeMap<String, Number>,
    /// Of a policy behind a socket: simulated time from an observation to its actions (ms).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latency_ms: Option<u32>,
    /// Fault of its observations; not there without.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// Answers that were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub requests: Option<u64>,
    /// Steps in which an arm held or repeated the last action of an answer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stale_steps: Option<u64>,
    /// Hash of all answers, 16 hexadecimal digits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub answers: Option<String>,
    /// How it ended.
    pub outcome: RowOutcome,
    /// Why it did not end done, if that is known.
    pub reason: Option<String>,
    /// The reason, or the newest fault, in a sentence; null in rows of older versions.
    #[serde(default)]
    pub message: Option<String>,
    /// Simulated time (s).
    pub sim_time_s: f64,
    /// Ticks simulated.
    pub ticks: u64,
    /// Objects in place, by name.
    pub placed: Vec<String>,
    /// Held objects that were lost.
    pub drops: u32,
    /// Pick-ups begun again.
    pub resyncs: u32,
    /// Transfers turned back.
    pub aborts: u32,
    /// Recoveries of any other kind.
    pub recoveries: u32,
    /// Starts of the task after the first; 0 in rows of older versions.
    #[serde(default)]
    pub task_restarts: u32,
    /// Commands and positions outside the limits of a joint.
    pub limit_violations: u64,
    /// Times an arm began to touch an obstacle.
    pub obstacle_contacts: u64,
    /// Times parts of an arm began to overlap.
    pub self_contacts: u64,
    /// Script lines that never fired.
    pub script_left: u32,
    /// Hash of the last state, 16 hexadecimal digits; empty after an error.
    pub state_hash: String,
    /// Hashes of colour, depth and mask of the last picture of each camera of `--frame-hash`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub frames: BTreeMap<String, String>,
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_zero(variant: &u32) -> bool {
    *variant == 0
}

impl Row {
    /// Which episode of an evaluation it is.
    pub fn key(&self) -> Key {
        Key {
            seed: self.seed,
            variant: self.variant,
        }
    }

    /// The row of an episode that ended with `summary`.
    pub fn of(identity: &Identity, case: &Case, summary: &RunSummary) -> Self {
        let outcome = match summary.outcome {
            RunOutcome::Done => RowOutcome::Done,
            RunOutcome::Failed => RowOutcome::Failed,
            RunOutcome::Timeout | RunOutcome::Stopped => RowOutcome::Timeout,
        };
        let server = summary.policy_server.as_ref();
        Self {
            demo: summary.demo.clone(),
            policy: summary.policy.clone(),
            build: identity.build.clone(),
            inputs: identity.inputs.clone(),
            seed: case.seed,
            variant: case.variant,
            set: by_key(&case.set),
            drawn: by_key(&case.drawn),
            latency_ms: server.map(|server| server.latency_ms),
            fault: server.and_then(|server| server.fault.clone()),
            requests: server.map(|server| server.requests),
            stale_steps: server.map(|server| server.stale_steps),
            answers: server.map(|server| server.answers.clone()),
            outcome,
            reason: summary.reason.clone(),
            message: summary.message.clone(),
            sim_time_s: summary.sim_time_s,
            ticks: summary.ticks,
            placed: summary.placed.clone(),
            drops: summary.drops,
            resyncs: summary.resyncs,
            aborts: summary.aborts,
            recoveries: summary.recoveries,
            task_restarts: summary.task_restarts,
            limit_violations: summary.limit_violations,
            obstacle_contacts: summary.obstacle_contacts,
            self_contacts: summary.self_contacts,
            script_left: summary.script_left,
            state_hash: summary.state_hash.clone(),
            frames: summary.frames.clone(),
        }
    }

    /// The row of an episode the program could not finish.
    pub fn error(
        identity: &Identity,
        (demo, policy): (&str, &str),
        case: &Case,
        reason: String,
    ) -> Self {
        Self {
            demo: demo.to_owned(),
            policy: policy.to_owned(),
            build: identity.build.clone(),
            inputs: identity.inputs.clone(),
            seed: case.seed,
            variant: case.variant,
            set: by_key(&case.set),
            drawn: by_key(&case.drawn),
            latency_ms: case.latency_ms,
            fault: case.fault.as_ref().map(ToString::to_string),
            requests: None,
            stale_steps: None,
            answers: None,
            outcome: RowOutcome::Error,
            message: Some(reason.clone()),
            reason: Some(reason),
            sim_time_s: 0.0,
            ticks: 0,
            placed: Vec::new(),
            drops: 0,
            resyncs: 0,
            aborts: 0,
            recoveries: 0,
            task_restarts: 0,
            limit_violations: 0,
            obstacle_contacts: 0,
            self_contacts: 0,
            script_left: 0,
            state_hash: String::new(),
            frames: BTreeMap::new(),
        }
    }
}
