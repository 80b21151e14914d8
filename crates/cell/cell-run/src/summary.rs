//! The summary of a run, as printed by `--json`.

use std::collections::BTreeMap;
use std::path::PathBuf;

use ipc_types::decision::{Outcome, POLICY_BYTES};
use ipc_types::{Decision, TICK_NS, Text, WorldState};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::record::RecordReport;
use crate::script_report::ScriptReply;
use cell_model::runs::policy_server::ServerReport;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RunOutcome {
    /// The task finished.
    Done,
    /// The task gave up; see `reason`.
    Failed,
    /// The time limit came first.
    Timeout,
    /// The run was stopped before the task ended.
    Stopped,
}

/// The last line of a run with `--json`; the keys and their order are a
/// contract.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunSummary {
    /// Name of the demo.
    pub demo: String,
    /// Name of the policy.
    pub policy: String,
    /// Seed of the run.
    pub seed: u64,
    /// How it ended.
    pub outcome: RunOutcome,
    /// Stable name of the reason, if any.
    pub reason: Option<String>,
    /// The reason, or the newest fault, in a sentence; null where the task is done or nothing
    /// went wrong.
    #[serde(default)]
    pub message: Option<String>,
    /// Simulated time (s).
    pub sim_time_s: f64,
    /// Time it took (s).
    pub wall_time_s: f64,
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
    /// Starts of the task after the first.
    pub task_restarts: u32,
    /// Missed cycles of all controllers, as in their health.
    pub missed_cycles: u64,
    /// Commands and positions outside the limits of a joint.
    pub limit_violations: u64,
    /// Times an arm began to touch an obstacle.
    pub obstacle_contacts: u64,
    /// Times parts of an arm began to overlap.
    pub self_contacts: u64,
    /// Script lines that never fired.
    pub script_left: u32,
    /// Hash of the last state, 16 hexadecimal digits.
    pub state_hash: String,
    /// Messages the recorder did not record.
    pub record_gaps: u64,
    /// Bytes in the file of `--record`.
    pub record_bytes: u64,
    /// Why what was recorded is not complete, if it is not.
    pub record_error: Option<String>,
    /// Faults that processes reported, as `physics: REASON`, each once; missing without one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faults: Vec<String>,
    /// Files of `--record` in the order of time: a recorder that was restarted continues in
    /// another. Missing without one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    #[schemars(with = "Vec<String>")]
    pub record_files: Vec<PathBuf>,
    /// Starts after the first of each process that was restarted, by its name; missing
    /// where none was.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub restarts: BTreeMap<String, u32>,
    /// Hashes of colour, depth and mask of the last picture of each camera of `--frame-hash`, by its
    /// name; missing without one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub frames: BTreeMap<String, String>,
    /// Use of a policy behind a socket, of a run in one process; missing without one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub policy_server: Option<ServerReport>,
    /// What became of the lines of the script; missing without one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub script_replies: Vec<ScriptReply>,
}

/// Facts of a run beside its messages.
#[derive(Clone, Copy, Debug)]
pub struct RunFacts<'a> {
    /// Name of the demo.
    pub demo: &'a str,
    /// Name of the policy with which the run started.
    pub policy: &'a str,
    /// Seed of the run.
    pub seed: u64,
    /// Names of the objects, in the order of the cell file.
    pub objects: &'a [String],
    /// Wall time (s).
    pub wall_time_s: f64,
    /// Starts of the task after the first.
    pub task_restarts: u32,
    /// Missed cycles of all controllers, as in their health.
    pub missed_cycles: u64,
}

impl RunSummary {
    /// The summary of a run that ended with `state` and `decision`.
    pub fn new(facts: &RunFacts<'_>, state: &WorldState, decision: &Decision) -> Self {
        let outcome = match Outcome::from_code(decision.outcome) {
            Some(Outcome::Done) => RunOutcome::Done,
            Some(Outcome::Failed) => RunOutcome::Failed,
            _ => RunOutcome::Timeout,
        };
        // The decision names the policy that ran last: a task can be restarted with another
        // one.
        let policy = decision.policy.as_str();
        let placed =
            &decision.placed[..(decision.placed_count as usize).min(decision.placed.len())];
        let name = |index: &u32| facts.objects.get(*index as usize).cloned();
        Self {
            demo: facts.demo.to_owned(),
            // The decision has room for the start of a long name only.
            policy: if policy.is_empty()
                || Text::<POLICY_BYTES>::new(facts.policy).as_str() == policy
            {
                facts.policy
            } else {
                policy
            }
            .to_owned(),
            seed: facts.seed,
            outcome,
            reason: (!decision.reason.is_empty()).then(|| decision.reason.as_str().to_owned()),
            message: None,
            sim_time_s: (state.header.tick * TICK_NS) as f64 / 1.0e9,
            wall_time_s: facts.wall_time_s,
            ticks: state.header.tick,
            placed: placed.iter().filter_map(name).collect(),
            drops: decision.drops,
            resyncs: decision.resyncs,
            aborts: decision.aborts,
            recoveries: decision.recoveries,
            task_restarts: facts.task_restarts,
            missed_cycles: facts.missed_cycles,
            limit_violations: state.arms().iter().map(|a| a.limit_violations).sum(),
            obstacle_contacts: state.arms().iter().map(|a| a.obstacle_contacts).sum(),
            self_contacts: state.arms().iter().map(|a| a.self_contacts).sum(),
            script_left: state.script_left,
            state_hash: format!("{:016x}", state.state_hash),
            record_gaps: 0,
            record_bytes: 0,
            record_error: None,
            faults: Vec::new(),
            record_files: Vec::new(),
            restarts: BTreeMap::new(),
            frames: BTreeMap::new(),
            policy_server: None,
            script_replies: Vec::new(),
        }
    }

    /// Adds the reason for which the run did not end done: `told` of the task, or else the
    /// words of its reason code.
    #[must_use]
    pub fn with_message(mut self, told: Option<&str>) -> Self {
        let words = || self.reason.as_ref().map(|reason| reason.replace('_', " "));
        self.message = match self.outcome {
            RunOutcome::Done => None,
            _ => told.map(str::to_owned).or_else(words),
        };
        self
    }

    /// Takes over the report of the recorder.
    pub fn set_record(&mut self, report: RecordReport) {
        self.record_gaps = report.gaps;
        self.record_bytes = report.bytes;
        self.record_error = report.error;
        self.record_files = report.files;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    #[test]
    fn the_keys_and_their_order_are_the_published_ones() {
        let facts = RunFacts {
            demo: "franka-stack",
            policy: "fsm",
            seed: 3,
            objects: &["red_cube".to_owned()],
            wall_time_s: 1.5,
            task_restarts: 0,
            missed_cycles: 0,
        };
        let mut decision = Decision::zeroed();
        decision.outcome = Outcome::Done.code();
        decision.placed_count = 1;
        let mut state = WorldState::zeroed();
        state.header.tick = 1500;
        let line = serde_json::to_string(&RunSummary::new(&facts, &state, &decision)).unwrap();
        assert_eq!(
            line,
            r#"{"demo":"franka-stack","policy":"fsm","seed":3,"outcome":"done","reason":null,"message":null,"sim_time_s":1.5,"wall_time_s":1.5,"ticks":1500,"placed":["red_cube"],"drops":0,"resyncs":0,"aborts":0,"recoveries":0,"task_restarts":0,"missed_cycles":0,"limit_violations":0,"obstacle_contacts":0,"self_contacts":0,"script_left":0,"state_hash":"0000000000000000","record_gaps":0,"record_bytes":0,"record_error":null}"#
        );
    }
}
