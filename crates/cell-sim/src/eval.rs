//! Many seeds, each a run of its own.

use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use cell_model::runs::spec::{RecordSpec, RunSpec, Speed};
use cell_model::runs::summary::{RunOutcome, RunSummary};
use cell_model::runs::wire;

use schemars::JsonSchema;
use serde::Serialize;

use crate::run::to_the_end;
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

/// Runs every seed once; `on_row` gets each row as it comes, in any order.
/// Returns what became of all.
pub fn evaluate(
    program: &Program,
    plan: &Plan,
    on_row: impl Fn(&RunSummary) + Sync,
) -> Result<EvalSummary, SimError> {
    let next = AtomicU64::new(*plan.seeds.start());
    let counts = Mutex::new(EvalSummary {
        demo: plan.spec.demo.clone(),
        policy: plan.spec.policy.clone(),
        seeds: [*plan.seeds.start(), *plan.seeds.end()],
        ..EvalSummary::default()
    });
    let worker = || -> Result<(), SimError> {
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if !plan.seeds.contains(&seed) {
                return Ok(());
            }
            let summary = to_the_end(
                program,
                &RunSpec {
                    seed,
                    ..plan.spec.clone()
                },
                |_, _| {},
            )?;
            on_row(&summary);
            let mut counts = counts
                .lock()
                .unwrap_or_else(std::sync::PoisonError::into_inner);
            counts.add(&summary);
        }
    };
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..plan.jobs.max(1)).map(|_| scope.spawn(worker)).collect();
        threads
            .into_iter()
            .try_for_each(|thread| match thread.join() {
                Ok(result) => result,
                Err(panic) => std::panic::resume_unwind(panic),
            })
    })?;
    Ok(counts
        .into_inner()
        .unwrap_or_else(std::sync::PoisonError::into_inner))
}
