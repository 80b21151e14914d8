//! Many episodes in parallel: an error, a panic or a warning of one episode does not end the
//! others.

use std::any::Any;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use cell_model::cells::sweep::{Case, Cases, Sweep};
use cell_model::runs::policy_server::PolicyServer;
use cell_run::spec::RunSpec;
use cell_run::summary::{RunOutcome, RunSummary};

use crate::run::{RunMessage, to_the_end_unless};
use crate::{OneProcess, Program, SimError};

/// One finished episode.
#[derive(Clone, Debug)]
pub struct Ended {
    /// Seed and settings of the episode.
    pub case: Case,
    /// Its summary, or the error that ended it.
    pub result: Result<RunSummary, String>,
    /// Warnings in the order in which they were reported.
    pub warnings: Vec<String>,
    /// Wall time of the episode, its setup included.
    pub wall_time: Duration,
}

/// A set of episodes of one task program.
pub struct Episodes<'a> {
    /// The task, and the cells that it brings.
    pub program: &'a Program,
    /// Template of each episode; the seed and the settings of a case replace its own.
    pub spec: &'a RunSpec,
    /// Directory for a recording of each episode, by [`recording_name`].
    pub record: Option<&'a Path>,
    /// Number of threads; 0 counts as 1.
    pub jobs: usize,
    /// Polled at every tick; `true` ends all episodes early. Episodes in progress are not
    /// reported.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Episodes<'_> {
    /// Runs `cases`. `on_end` is called from the worker threads with each finished episode, in
    /// any order; it returns whether to continue.
    pub fn run(
        &self,
        cases: impl Iterator<Item = Case> + Send,
        on_end: &(dyn Fn(Ended) -> bool + Sync),
    ) {
        // The lock is held only to take the next case. Episodes differ in length, so a fixed
        // share for each thread would leave threads idle at the end.
        let cases = Mutex::new(cases);
        let next = || cases.lock().unwrap_or_else(PoisonError::into_inner).next();
        // A flag besides `stop`: `on_end` may end all episodes while `stop` still returns
        // `false`.
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

    /// `None` if the episode was stopped.
    fn one(&self, case: Case, stop: &dyn Fn() -> bool) -> Option<Ended> {
        if stop() {
            return None;
        }
        let began = Instant::now();
        let mut spec = self.spec.clone();
        // The case is applied to a copy, so that no setting of one episode reaches the next.
        spec.seed = case.seed;
        spec.set.extend(case.settings());
        let name = episode_name(case.seed, case.variant);
        spec.record.file = self
            .record
            .map(|dir| dir.join(recording_name(case.seed, case.variant)));
        spec.policy_server = server_of(spec.policy_server, &case, &name);
        let mut warnings = Vec::new();
        let run = || {
            to_the_end_unless(self.program, &spec, stop, |said| {
                if let RunMessage::Warning(warning) = said {
                    warnings.push(warning.to_owned());
                }
            })
        };
        // A panic of one policy must not end an evaluation of hours: it becomes the result of
        // this episode. Only `warnings` is read after a panic, and it is complete after each
        // push.
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

/// Name of an episode in names of files.
pub fn episode_name(seed: u64, variant: u32) -> String {
    match variant {
        0 => format!("seed-{seed}"),
        variant => format!("seed-{seed}-variant-{variant}"),
    }
}

/// Name of the file with the recording of an episode.
pub fn recording_name(seed: u64, variant: u32) -> String {
    format!("{}.mcap", episode_name(seed, variant))
}

/// The use of a policy server in an episode; `None` where neither the run nor the case has one.
fn server_of(server: Option<PolicyServer>, case: &Case, name: &str) -> Option<PolicyServer> {
    let server = server.map(|server| server.of_episode(name));
    if case.latency_ms.is_none() && case.fault.is_none() {
        return server;
    }
    let server = server.unwrap_or_default();
    Some(PolicyServer {
        latency_ms: case.latency_ms.unwrap_or(server.latency_ms),
        fault: case.fault.clone(),
        ..server
    })
}

fn message(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    let owned = panic.downcast_ref::<String>().map(String::as_str);
    text.or(owned).unwrap_or("without a message")
}

/// The text of every file that an episode of `spec` reads, by name: those of the cell, its
/// robots and its behaviours. These are the inputs of an evaluation (ADR 0023).
///
/// # Errors
/// Returns an error if the first episode cannot start.
pub fn files(program: &Program, spec: &RunSpec) -> Result<BTreeMap<String, String>, SimError> {
    let (data, log) = spec.data(&program.data).logged();
    let mut cell = spec.load_cell_of(&data)?;
    if cell.policy_server.is_some() {
        // Errors of its options are reported here. The first decision sends no request.
        program.policies.task(&cell, &spec.policy)?;
        cell.policy_server = None;
    }
    // The task reads more files while it is set up. A scene that cannot be set up may depend on
    // the seed, so it is not an error here: each episode reports its own.
    match OneProcess::with(&program.policies, &program.controllers, spec, cell) {
        Ok(sim) => {
            sim.frames(&spec.frame_hash)?;
            Ok(log.files())
        }
        Err(SimError::World(_)) => Ok(log.files()),
        Err(error) => Err(error),
    }
}

/// The episodes of `sweep`. Each of its values is tried first: the cell and its task are set up
/// with it, so a wrong value ends the evaluation before its first episode.
///
/// # Errors
/// A key or a value that the cell or the task refuses.
pub fn cases(program: &Program, spec: &RunSpec, sweep: Sweep) -> Result<Cases, SimError> {
    let (file, text) = cell_file(program, spec)?;
    let cases = sweep.cases(&file, &text)?;
    for case in cases.samples(spec.seed) {
        try_settings(program, spec, &case)?;
    }
    Ok(cases)
}

/// Name for messages, and text, of the cell file.
fn cell_file(program: &Program, spec: &RunSpec) -> Result<(String, Cow<'static, str>), SimError> {
    let data = spec.data(&program.data);
    // Loaded first for its error: an unknown demo is refused with the list of the known ones,
    // while reading the file alone would report a missing file.
    spec.load_cell_of(&data)?;
    let file = format!("cells/{}.toml", spec.demo);
    Ok((data.name_of(&file), data.read(&file)?))
}

/// Sets up the cell and its task of a case, and drops them.
fn try_settings(program: &Program, spec: &RunSpec, case: &Case) -> Result<(), SimError> {
    let spec = RunSpec {
        set: case.settings(),
        policy_server: server_of(spec.policy_server.clone(), case, ""),
        ..spec.clone()
    };
    let cell = spec.load_cell_from(&program.data)?;
    program.policies.task(&cell, &spec.policy)?;
    Ok(())
}
