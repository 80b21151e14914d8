//! Many plans, on several threads, with a result that does not depend on their number.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::check::Failed;
use crate::draw;
use crate::plan::{Fault, Plan};
use crate::run::{Outcome, run};

/// A plan that failed.
#[derive(Clone, Debug)]
pub struct Failure {
    /// The plan.
    pub plan: Plan,
    /// Why.
    pub failed: Failed,
}

/// What many plans showed.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Number of plans.
    pub schedules: u64,
    /// Simulated time (s).
    pub simulated_s: f64,
    /// Simulated seconds by seconds of processor time.
    pub x_real_time: f64,
    /// Hash over all runs, in the order of their seeds.
    pub digest: String,
    /// By kind: its name, faults that were drawn, and those that had something to act on.
    pub faults: Vec<(&'static str, u32, u32)>,
    /// Seeds that failed.
    pub failed: Vec<u64>,
}

/// The plans of `seeds`, each of at most `longest_ms`, on `jobs` threads, until `limit` is over.
///
/// # Errors
/// In words, where the generator drew a plan that cannot run.
pub fn seeds(
    seeds: Range<u64>,
    longest_ms: u64,
    jobs: usize,
    limit: Option<Duration>,
) -> Result<(Summary, Vec<Failure>), String> {
    let began = Instant::now();
    let next = AtomicU64::new(seeds.start);
    let done = Mutex::new(Vec::new());
    let busy = Mutex::new(Duration::ZERO);
    let work = || {
        let since = Instant::now();
        while limit.is_none_or(|limit| began.elapsed() < limit) {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                break;
            }
            let plan = draw::plan(seed, longest_ms);
            let outcome = examine(&plan);
            if let Ok(mut done) = done.lock() {
                done.push((plan, outcome));
            }
        }
        if let Ok(mut busy) = busy.lock() {
            *busy += since.elapsed();
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(work);
        }
    });
    let mut done = done.into_inner().map_err(|error| error.to_string())?;
    done.sort_by_key(|(plan, _)| plan.seed);
    let busy = busy.into_inner().map_err(|error| error.to_string())?;
    summarise(done, busy)
}

fn summarise(
    done: Vec<(Plan, Result<Outcome, String>)>,
    busy: Duration,
) -> Result<(Summary, Vec<Failure>), String> {
    let mut digest = DefaultHasher::new();
    let mut summary = Summary::default();
    let mut drawn = [[0; 2]; Fault::KINDS.len()];
    let mut failures = Vec::new();
    for (plan, outcome) in done {
        let outcome = outcome.map_err(|why| format!("seed {}: {why}", plan.seed))?;
        summary.schedules += 1;
        summary.simulated_s += outcome.simulated_ms as f64 * 1.0e-3;
        (plan.seed, outcome.digest).hash(&mut digest);
        let ran_us = outcome.simulated_ms * 1000;
        for timed in plan.faults.iter().filter(|timed| timed.at_us < ran_us) {
            drawn[timed.fault.kind()][0] += 1;
        }
        for (kind, effective) in outcome.effective.iter().enumerate() {
            drawn[kind][1] += effective;
        }
        if let Some(failed) = outcome.failed {
            summary.failed.push(plan.seed);
            failures.push(Failure { plan, failed });
        }
    }
    summary.digest = format!("{:016x}", digest.finish());
    summary.x_real_time = summary.simulated_s / busy.as_secs_f64().max(1.0e-9);
    let names = Fault::KINDS.iter().zip(drawn);
    summary.faults = names
        .map(|(name, [drawn, effective])| (*name, drawn, effective))
        .collect();
    Ok((summary, failures))
}

/// Runs `plan`; a plan in lockstep whose faults leave the motion alone is compared with the same
/// without them: invariant 19.
///
/// # Errors
/// In words, where the plan cannot run.
pub fn examine(plan: &Plan) -> Result<Outcome, String> {
    let mut outcome = run(plan)?;
    if outcome.failed.is_some() || !plan.lockstep || !leaves_motion(plan) {
        return Ok(outcome);
    }
    let calm = run(&plan.calm())?;
    let of_calm = |tick: &u64| calm.hashes.iter().find(|(other, _)| other == tick);
    let differs = |(tick, hash): &&(u64, u64)| of_calm(tick).is_some_and(|(_, of)| of != hash);
    if let Some((tick, _)) = outcome.hashes.iter().find(differs) {
        outcome.failed = Some(Failed {
            invariant: 19,
            at_us: plan.horizon_ms * 1000,
            why: format!("tick {tick} has another state hash than without faults"),
        });
    }
    Ok(outcome)
}

/// Whether all faults are kills of the task or of the monitor. A new controller starts where the
/// arm is, so its motion differs by a little.
fn leaves_motion(plan: &Plan) -> bool {
    let is_other = |fault: &Fault| match fault {
        Fault::Kill { process, .. } => process == "task" || process == "monitor",
        _ => false,
    };
    !plan.faults.is_empty() && plan.faults.iter().all(|timed| is_other(&timed.fault))
}
