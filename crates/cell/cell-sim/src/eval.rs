//! Evaluation of a policy: one run for each seed and each combination of settings.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use cell_model::cells::setting::Setting;
use cell_model::cells::sweep::{Case, Cases};
use cell_run::spec::{RecordSpec, RunSpec, Speed};
use cell_run::summary::{RunOutcome, RunSummary};
use cell_run::wire;

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Number;

use crate::episodes::{self, Ended, Episodes};
use crate::{Program, SimError};

/// An evaluation.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Template: everything but the seed and the settings.
    pub spec: RunSpec,
    /// The settings that replace numbers of the cell file.
    pub cases: Cases,
    /// First and last seed, both included.
    pub seeds: RangeInclusive<u64>,
    /// Number of threads.
    pub jobs: usize,
    /// Directory for a recording of each episode.
    pub record: Option<PathBuf>,
}

impl Plan {
    /// Their number; at most [`u64::MAX`].
    pub fn episodes(&self) -> u64 {
        // Saturating: the range of all seeds has one element more than `u64::MAX`.
        let seeds = self.seeds.end().saturating_sub(*self.seeds.start());
        let variants = self.cases.sweep().variants().count() as u64;
        seeds.saturating_add(1).saturating_mul(variants)
    }

    /// A copy with one more setting, which applies to all episodes.
    #[must_use]
    pub fn with(&self, setting: &Setting) -> Self {
        let mut plan = self.clone();
        plan.spec.set.push(setting.clone());
        plan
    }

    /// Each episode: every combination of values with every seed.
    pub fn all(&self) -> impl Iterator<Item = Case> + '_ {
        let variants = self.cases.sweep().variants();
        // With seeds as the outer loop an evaluation that ends early has run all variants with
        // its first seeds, so they can be compared.
        self.seeds.clone().flat_map(move |seed| {
            let variants = variants.clone();
            variants.map(move |variant| self.cases.case(seed, variant))
        })
    }
}

/// A run file for cells without processes: empty paths, one arm, the largest speed.
pub fn template(demo: &str, policy: &str) -> RunSpec {
    RunSpec {
        contract: wire::contract(),
        run: 1,
        cell: "one-process".to_owned(),
        demo: demo.to_owned(),
        command: String::new(),
        policy: policy.to_owned(),
        seed: 0,
        speed: Speed::Max,
        data_dir: None,
        task_program: None,
        controller_programs: Vec::new(),
        fci: Vec::new(),
        built_in_dir: PathBuf::new(),
        run_dir: PathBuf::new(),
        root: PathBuf::new(),
        prefix: String::new(),
        arms: 1,
        robot: None,
        script: Vec::new(),
        paused: false,
        bins: None,
        set: Vec::new(),
        replace: Vec::new(),
        action_hz: None,
        frame_hash: Vec::new(),
        policy_server: None,
        until_done: true,
        time_limit_s: None,
        real_time: false,
        page: None,
        record: RecordSpec::default(),
        incidents_dir: PathBuf::new(),
        warnings: Vec::new(),
    }
}

/// Result of all runs.
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

/// A run, and its numbers in place of those of the cell file.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub struct EvalRun {
    /// How it ended.
    #[serde(flatten)]
    pub summary: RunSummary,
    /// By the keys of the cell file; not there where there are none.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub set: BTreeMap<String, Number>,
}

/// One line of `eval --json`: each run as it ends, then the summary of all.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum EvalLine {
    /// A run.
    Run(Box<EvalRun>),
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

/// Runs every case once; `on_end` gets each run as it ends, in any order. A run that ended with
/// an error counts as a run that is not done. Returns the totals.
///
/// # Errors
/// Returns an error if no run can start, with any seed.
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
    // Loads everything once with the first seed, only for the error: without it each of a
    // thousand runs would report the same wrong file.
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
        record: plan.record.as_deref(),
        jobs: plan.jobs,
        stop: &|| false,
    }
    .run(plan.all(), &|ended| {
        on_end(&ended);
        let mut counts = counts.lock().unwrap_or_else(PoisonError::into_inner);
        match &ended.result {
            Ok(summary) => counts.add(summary),
            // Errors count as runs, so that `done` of `runs` is the rate of success.
            Err(_) => counts.runs += 1,
        }
        true
    });
    Ok(counts.into_inner().unwrap_or_else(PoisonError::into_inner))
}
