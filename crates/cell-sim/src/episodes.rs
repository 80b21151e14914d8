//! Many episodes, none of which ends the others.

use std::any::Any;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use cell_model::cells::axis::Axis;
use cell_model::cells::setting::Setting;
use cell_model::cells::sweep::{Bounds, Case, Cases, Sweep};
use cell_model::runs::spec::RunSpec;
use cell_model::runs::summary::{RunOutcome, RunSummary};

use crate::run::{Said, to_the_end_unless};
use crate::{OneProcess, Program, SimError};

/// What became of one episode.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Which.
    pub case: Case,
    /// Its summary, or why it could not be finished.
    pub result: Result<RunSummary, String>,
    /// Warnings about it.
    pub warnings: Vec<String>,
    /// Time it took.
    pub wall_time: Duration,
}

/// Which episodes, and how.
pub struct Episodes<'a> {
    /// The task, and the cells that come with it.
    pub program: &'a Program,
    /// Everything but the seed, and the numbers that differ between them.
    pub spec: &'a RunSpec,
    /// Threads.
    pub jobs: usize,
    /// Ends all of them early; those in progress are not reported.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Episodes<'_> {
    /// Runs those of `cases`; `on_end` gets each as it ends, in any order, and says whether
    /// to continue.
    pub fn run(
        &self,
        cases: impl Iterator<Item = Case> + Send,
        on_end: &(dyn Fn(Ended) -> bool + Sync),
    ) {
        let cases = Mutex::new(cases);
        let next = || cases.lock().unwrap_or_else(PoisonError::into_inner).next();
        let has_ended = AtomicBool::new(false);
        let stop = || (self.stop)() || has_ended.load(Ordering::Relaxed);
        let worker = || {
            while let Some(case) = next() {
                let Some(one) = self.one(case, &stop) else {
                    return;
                };
                if !on_end(one) {
                    has_ended.store(true, Ordering::Relaxed);
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..self.jobs.max(1) {
                scope.spawn(worker);
            }
        });
    }

    /// `None` when it was stopped.
    fn one(&self, case: Case, stop: &dyn Fn() -> bool) -> Option<Ended> {
        if stop() {
            return None;
        }
        let began = Instant::now();
        let mut spec = self.spec.clone();
        spec.seed = case.seed;
        spec.set.extend(case.settings());
        let mut warnings = Vec::new();
        let run = || {
            to_the_end_unless(self.program, &spec, stop, |said| {
                if let Said::Warning(warning) = said {
                    warnings.push(warning.to_owned());
                }
            })
        };
        let result = match catch_unwind(AssertUnwindSafe(run)) {
            Ok(Ok(summary)) if summary.outcome == RunOutcome::Stopped => return None,
            Ok(Ok(summary)) => Ok(summary),
            Ok(Err(error)) => Err(error.to_string()),
            Err(panic) => Err(format!("panic: {}", message(&*panic))),
        };
        Some(Ended {
            case,
            result,
            warnings,
            wall_time: began.elapsed(),
        })
    }
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    text.or(owned).unwrap_or("without a message")
}

/// Every file that an episode of `spec` is made from, by name, with its text: those of the
/// cell, its robots and its behaviours.
///
/// # Errors
/// Where the first episode cannot begin.
pub fn files(program: &Program, spec: &RunSpec) -> Result<BTreeMap<String, String>, SimError> {
    let (data, log) = spec.data(&program.data).logged();
    let cell = spec.load_cell_of(&data)?;
    // Its task reads more. A scene that cannot be set up is one with this seed.
    match OneProcess::with(&program.policies, &program.controllers, spec, cell) {
        Ok(_) | Err(SimError::World(_)) => Ok(log.files()),
        Err(error) => Err(error),
    }
}

/// The episodes of `sweep`, after each of its values was tried: the cell and its task are
/// set up with it.
///
/// # Errors
/// A key or a value that the cell or the task refuses.
pub fn cases(program: &Program, spec: &RunSpec, sweep: Sweep) -> Result<Cases, SimError> {
    let (file, text) = cell_file(program, spec)?;
    let cases = sweep.cases(&file, &text)?;
    for case in cases.samples(spec.seed) {
        try_settings(program, spec, case.settings())?;
    }
    Ok(cases)
}

/// The number whose value is searched for, after both bounds were tried as by [`cases`].
///
/// # Errors
/// A key or a bound that the cell or the task refuses.
pub fn axis(program: &Program, spec: &RunSpec, bounds: Bounds) -> Result<Axis, SimError> {
    let (file, text) = cell_file(program, spec)?;
    let axis = Axis::new(bounds, &file, &text)?;
    for end in axis.ends() {
        try_settings(program, spec, vec![axis.at(&end)])?;
    }
    Ok(axis)
}

/// Name for messages, and text, of the cell file.
fn cell_file(program: &Program, spec: &RunSpec) -> Result<(String, Cow<'static, str>), SimError> {
    let data = spec.data(&program.data);
    // A demo that is unknown is refused with those that are known.
    spec.load_cell_of(&data)?;
    let file = format!("cells/{}.toml", spec.demo);
    Ok((data.name_of(&file), data.read(&file)?))
}

/// Sets the cell and its task up with these numbers.
fn try_settings(program: &Program, spec: &RunSpec, set: Vec<Setting>) -> Result<(), SimError> {
    let spec = RunSpec {
        set,
        ..spec.clone()
    };
    let cell = spec.load_cell_from(&program.data)?;
    program.policies.task(&cell, &spec.policy)?;
    Ok(())
}
