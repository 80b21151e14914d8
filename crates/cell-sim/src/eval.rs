//! Many seeds, each a run of its own.

use std::ops::RangeInclusive;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use cell_model::runs::spec::{RecordSpec, RunSpec, Speed};
use cell_model::runs::summary::{RunOutcome, RunSummary};

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

/// Runs every seed once; `on_row` gets each row as it comes, in any order.
/// Returns how many ended done.
pub fn evaluate(
    program: &Program,
    plan: &Plan,
    on_row: impl Fn(&RunSummary) + Sync,
) -> Result<(u64, u64), SimError> {
    let next = AtomicU64::new(*plan.seeds.start());
    let counts = Mutex::new((0_u64, 0_u64));
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
            counts.0 += u64::from(summary.outcome == RunOutcome::Done);
            counts.1 += 1;
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
