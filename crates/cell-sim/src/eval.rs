//! Many seeds, each a run of its own.

use std::ops::RangeInclusive;
use std::sync::{Mutex, PoisonError};

use cell_model::runs::spec::{RecordSpec, RunSpec, Speed};
use cell_model::runs::summary::{RunOutcome, RunSummary};
use cell_model::runs::wire;

use schemars::JsonSchema;
use serde::Serialize;

use crate::episodes::{self, Ended, Episodes};
use crate::{Program, SimError};

/// What to evaluate.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Template: everything but the seed.
    pub spec: RunSpec,
    /// First and last seed.
    pub seeds: RangeInclusive<u64>,
    /// Threads.
    pub jobs: usize,
}

/// A run file for cells without processes.
pub fn template(demo: &str, policy: &str) -> RunSpec {
    RunSpec {
        contract: wire::contract(),
        run: 1,
        cell: "one-process".to_owned(),
        demo: demo.to_owned(),
        policy: policy.to_owned(),
        seed: 0,
        speed: Speed::Max,
        data_dir: None,
        task_program: None,
        controller_programs: Vec::new(),
        built_in_dir: std::path::PathBuf::new(),
        run_dir: std::path::PathBuf::new(),
        root: std::path::PathBuf::new(),
        prefix: String::new(),
        arms: 1,
        robot: None,
        script: Vec::new(),
        paused: false,
        bins: None,
        until_done: true,
        time_limit_s: None,
        real_time: false,
        page: None,
        record: RecordSpec::default(),
        incidents_dir: std::path::PathBuf::new(),
    }
}

/// What became of all runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct EvalSummary {
    /// Name of the demo.
    pub demo: String,
    /// Name of the policy.
    pub policy: String,
    /// First and last seed.
    pub seeds: [u64; 2],
    /// Runs.
    pub runs: u64,
    /// Of these, those that ended done.
    pub done: u64,
    /// Held objects that were lost, in all.
    pub drops: u64,
    /// Pick-ups begun again, in all.
    pub resyncs: u64,
    /// Transfers turned back, in all.
    pub aborts: u64,
    /// Recoveries of any other kind, in all.
    pub recoveries: u64,
    /// Commands and positions outside the limits of a joint, in all.
    pub limit_violations: u64,
    /// Simulated time of all runs (s).
    pub sim_time_s: f64,
    /// Of the longest (s).
    pub longest_s: f64,
}

/// One line of `eval --json`: each run as it ends, then the summary of all.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum EvalLine {
    /// A run.
    Run(Box<RunSummary>),
    /// All runs.
    All(EvalSummary),
}

impl EvalSummary {
    fn add(&mut self, row: &RunSummary) {
        self.runs += 1;
        self.done += u64::from(row.outcome == RunOutcome::Done);
        self.drops += u64::from(row.drops);
        self.resyncs += u64::from(row.resyncs);
        self.aborts += u64::from(row.aborts);
        self.recoveries += u64::from(row.recoveries);
        self.limit_violations += row.limit_violations;
        self.sim_time_s += row.sim_time_s;
        self.longest_s = self.longest_s.max(row.sim_time_s);
    }
}

/// Runs every seed once; `on_end` gets each run as it ends, in any order. One that could not
/// be finished counts as a run that is not done. Returns what became of all.
///
/// # Errors
/// Where no run could begin, whatever its seed.
pub fn evaluate(
    program: &Program,
    plan: &Plan,
    on_end: impl Fn(&Ended) + Sync,
) -> Result<EvalSummary, SimError> {
    let (first, last) = (*plan.seeds.start(), *plan.seeds.end());
    let spec = RunSpec {
        seed: first,
        ..plan.spec.clone()
    };
    episodes::files(program, &spec)?;
    let counts = Mutex::new(EvalSummary {
        demo: spec.demo.clone(),
        policy: spec.policy.clone(),
        seeds: [first, last],
        ..EvalSummary::default()
    });
    Episodes {
        program,
        spec: &spec,
        jobs: plan.jobs,
        stop: &|| false,
    }
    .run(plan.seeds.clone(), &|ended| {
        on_end(&ended);
        let mut counts = counts.lock().unwrap_or_else(PoisonError::into_inner);
        match &ended.result {
            Ok(summary) => counts.add(summary),
            Err(_) => counts.runs += 1,
        }
        true
    });
    Ok(counts.into_inner().unwrap_or_else(PoisonError::into_inner))
}
