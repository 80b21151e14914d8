//! One run to its end, and its summary.

use std::path::Path;
use std::time::Instant;

use cell_model::Cell;
use cell_model::cells::script::ScriptLine;
use cell_model::runs::spec::RunSpec;
use cell_model::runs::summary::{RunFacts, RunOutcome, RunSummary};

use crate::{OneProcess, Program, SimError};

/// Runs `spec` until its task is done or its time limit is reached. `on_line`
/// gets each log line of the task with its tick.
pub fn to_the_end(
    program: &Program,
    spec: &RunSpec,
    on_line: impl FnMut(u64, &str),
) -> Result<RunSummary, SimError> {
    to_the_end_unless(program, spec, &|| false, on_line)
}

/// As [`to_the_end`]; a run ends early, as stopped, when `stop` says so.
pub fn to_the_end_unless(
    program: &Program,
    spec: &RunSpec,
    stop: &dyn Fn() -> bool,
    mut on_line: impl FnMut(u64, &str),
) -> Result<RunSummary, SimError> {
    let began = Instant::now();
    let cell = spec.load_cell_from(&program.data)?;
    let objects: Vec<String> = cell.objects.iter().map(|o| o.name.clone()).collect();
    let limit_s = spec.time_limit_s.unwrap_or(cell.time_limit_s);
    let spec = RunSpec {
        time_limit_s: Some(limit_s),
        ..spec.clone()
    };
    let mut sim = OneProcess::with(&program.policies, &program.controllers, &spec, cell)?;
    // A cell that stands still before its end was paused by its script, and
    // no operator is present to resume it.
    let mut stopped = false;
    while sim.tick()? {
        if stop() {
            stopped = true;
            break;
        }
        for (tick, line) in sim.take_trace() {
            on_line(tick, &line);
        }
    }
    let facts = RunFacts {
        demo: &spec.demo,
        policy: &spec.policy,
        seed: spec.seed,
        objects: &objects,
        wall_time_s: began.elapsed().as_secs_f64(),
        task_restarts: sim.task_restarts(),
        missed_cycles: sim.statuses().iter().map(|s| s.missed_cycles).sum(),
    };
    let mut summary = RunSummary::new(&facts, sim.state(), sim.decision());
    if stopped {
        summary.outcome = RunOutcome::Stopped;
    }
    Ok(RunSummary {
        script_replies: sim.plant().script_replies().to_vec(),
        ..summary
    })
}

/// Reads a script file for `cell`.
pub fn script(path: &Path, cell: &Cell) -> Result<Vec<ScriptLine>, SimError> {
    let name = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|source| SimError::ScriptFile {
        path: name.clone(),
        source,
    })?;
    Ok(cell_model::cells::script::parse_for(&text, &name, cell)?)
}
