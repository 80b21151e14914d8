//! Many plans, on several threads, with a result that does not depend on their number.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::check::Failed;
use crate::coverage::{Coverage, NAMED};
use crate::draw::{self, Level};
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

/// A seed whose plan failed.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FailedSeed {
    /// The seed.
    pub seed: u64,
    /// The invariant.
    pub invariant: u32,
}

/// How many plans to run.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Seeds of the plans.
    pub seeds: Range<u64>,
    /// What they are about.
    pub level: Level,
    /// Longest time of a plan (ms).
    pub longest_ms: u64,
    /// Threads.
    pub jobs: usize,
    /// End after this time.
    pub limit: Option<Duration>,
    /// End with the first failure.
    pub first: bool,
}

/// What many plans showed.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Summary {
    /// Number of plans.
    pub schedules: u64,
    /// Simulated time (s).
    pub simulated_s: f64,
    /// Processor time (s).
    pub processor_s: f64,
    /// Simulated seconds by seconds of processor time.
    pub x_real_time: f64,
    /// Hash over all runs, in the order of their seeds.
    pub digest: String,
    /// By kind: its name, faults that were drawn, and those that had something to act on.
    pub faults: Vec<(&'static str, u32, u32)>,
    /// Combinations of states that were reached, by their hashes.
    pub combinations: usize,
    /// Named states that no plan reached.
    pub not_reached: Vec<&'static str>,
    /// Seeds of plans that reached a combination first.
    #[serde(skip)]
    pub firsts: Vec<u64>,
    /// Seeds that failed, and the invariant of each.
    pub failed: Vec<FailedSeed>,
}

/// Runs the plans of a batch.
///
/// # Errors
/// In words, where the generator drew a plan that cannot run.
pub fn run_all(batch: &Batch) -> Result<(Summary, Vec<Failure>), String> {
    let began = Instant::now();
    let next = AtomicU64::new(batch.seeds.start);
    let has_failed = AtomicBool::new(false);
    let done = Mutex::new(Vec::new());
    let busy = Mutex::new(Duration::ZERO);
    let work = || {
        let since = processor_time();
        let in_time = || batch.limit.is_none_or(|limit| began.elapsed() < limit);
        while in_time() && !(batch.first && has_failed.load(Ordering::Relaxed)) {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= batch.seeds.end {
                break;
            }
            let plan = draw::plan(seed, batch.level, batch.longest_ms);
            let mut outcome = examine(&plan);
            if let Ok(outcome) = &mut outcome {
                has_failed.fetch_or(outcome.failed.is_some(), Ordering::Relaxed);
                outcome.forget_run();
            }
            if let Ok(mut done) = done.lock() {
                done.push((plan, outcome));
            }
        }
        if let Ok(mut busy) = busy.lock() {
            *busy += processor_time().saturating_sub(since);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..batch.jobs {
            scope.spawn(work);
        }
    });
    let mut done = done.into_inner().map_err(|error| error.to_string())?;
    done.sort_by_key(|(plan, _)| plan.seed);
    let busy = busy.into_inner().map_err(|error| error.to_string())?;
    summarise(done, busy)
}

/// Time for which this thread had a core: what other programs take does not count.
fn processor_time() -> Duration {
    let stat = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let ran_ns = stat.split(' ').next().and_then(|ns| ns.parse().ok());
    Duration::from_nanos(ran_ns.unwrap_or(0))
}

fn summarise(
    done: Vec<(Plan, Result<Outcome, String>)>,
    busy: Duration,
) -> Result<(Summary, Vec<Failure>), String> {
    let mut digest = DefaultHasher::new();
    let mut summary = Summary::default();
    let mut drawn = [[0; 2]; Fault::KINDS.len()];
    let mut failures = Vec::new();
    let mut reached = Coverage::default();
    for (plan, outcome) in done {
        let outcome = outcome.map_err(|why| format!("seed {}: {why}", plan.seed))?;
        summary.schedules += 1;
        summary.simulated_s += outcome.simulated_ms as f64 * 1.0e-3;
        (plan.seed, outcome.digest).hash(&mut digest);
        let ran_us = outcome.ran_ms * 1000;
        for timed in plan.faults.iter().filter(|timed| timed.at_us < ran_us) {
            drawn[timed.fault.kind()][0] += 1;
        }
        for (kind, effective) in outcome.effective.iter().enumerate() {
            drawn[kind][1] += effective;
        }
        let count = reached.bits.len();
        reached.bits.extend(&outcome.coverage.bits);
        reached.named.extend(&outcome.coverage.named);
        if reached.bits.len() > count {
            summary.firsts.push(plan.seed);
        }
        if let Some(failed) = outcome.failed {
            let (seed, invariant) = (plan.seed, failed.invariant);
            summary.failed.push(FailedSeed { seed, invariant });
            failures.push(Failure { plan, failed });
        }
    }
    summary.combinations = reached.bits.len();
    let is_missing = |name: &&&str| !reached.named.contains(**name);
    summary.not_reached = NAMED.iter().filter(is_missing).copied().collect();
    summary.digest = format!("{:016x}", digest.finish());
    summary.processor_s = busy.as_secs_f64();
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
    let state = outcome.hashes.iter().find(differs).map(|(tick, _)| *tick);
    let of_calm = |tick: &u64| calm.decisions.get(tick);
    let differs = |(tick, said): &(&u64, &u64)| of_calm(tick).is_some_and(|of| of != *said);
    let decision = outcome
        .decisions
        .iter()
        .find(differs)
        .map(|(tick, _)| *tick);
    let other = state.map(|tick| format!("tick {tick} has another state hash"));
    let other = other.or(decision.map(|tick| format!("the decision of tick {tick} differs")));
    outcome.failed = other.map(|other| Failed {
        invariant: 19,
        at_us: plan.horizon_ms * 1000,
        why: format!("{other} from the run without faults"),
    });
    Ok(outcome)
}

/// Whether all faults are kills of the task or of the monitor, repeated messages or interrupted
/// turns. A new controller starts where the arm is, so its motion differs by a little.
fn leaves_motion(plan: &Plan) -> bool {
    let is_other = |fault: &Fault| match fault {
        Fault::Kill { process, .. } => process == "task" || process == "monitor",
        Fault::Repeat { .. } | Fault::Preempt { .. } => true,
        _ => false,
    };
    let are_others = plan.faults.iter().all(|timed| is_other(&timed.fault));
    let is_alone = plan.script.is_empty() && plan.people.is_empty();
    is_alone && are_others && !plan.faults.is_empty()
}
