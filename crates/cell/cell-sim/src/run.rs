//! One run to its end, with its summary.

use std::path::Path;
use std::time::Instant;

use cell_model::cells::script::ScriptLine;
use cell_model::{Cell, user_file};
use cell_run::report;
use cell_run::spec::RunSpec;
use cell_run::summary::{RunOutcome, RunSummary};

use crate::action::Hold;
use crate::record::Recorder;
use crate::{OneProcess, Program, SimError};

/// Reports of a run while it runs.
#[derive(Clone, Copy, Debug)]
pub enum RunMessage<'a> {
    /// A line of the task's log, and its tick.
    Line(u64, &'a str),
    /// A warning.
    Warning(&'a str),
}

/// Runs `spec` until its task is done or its time limit is reached. `on_message` gets each line
/// of the task's log and each warning, those of the first and of the last decision included.
pub fn to_the_end(
    program: &Program,
    spec: &RunSpec,
    on_message: impl FnMut(RunMessage<'_>),
) -> Result<RunSummary, SimError> {
    to_the_end_unless(program, spec, &|| false, on_message)
}

/// As [`to_the_end`], but the run ends early, as stopped, once `stop` returns `true`.
pub fn to_the_end_unless(
    program: &Program,
    spec: &RunSpec,
    stop: &dyn Fn() -> bool,
    mut on_message: impl FnMut(RunMessage<'_>),
) -> Result<RunSummary, SimError> {
    let began = Instant::now();
    let cell = spec.load_cell_from(&program.data)?;
    let limit_s = spec.time_limit_s.unwrap_or(cell.time_limit_s);
    // A run without its own limit takes that of the cell: a job that never ends would block a
    // thread of an evaluation for ever.
    let spec = RunSpec {
        time_limit_s: Some(limit_s),
        ..spec.clone()
    };
    let mut sim = OneProcess::with(&program.policies, &program.controllers, &spec, cell)?;
    // A wrong name must not cost the time of the run.
    sim.frames(&spec.frame_hash)?;
    let mut recorder = recorder(&spec)?;
    let mut stopped = false;
    loop {
        if let Some(recorder) = &mut recorder {
            recorder.take(&sim)?;
        }
        // News are taken after each call, also after one without a step: a job can end with its
        // first decision, before any tick.
        let advanced = sim.tick()?;
        report_new(&mut sim, &mut on_message);
        stopped |= advanced && stop();
        if stopped || !advanced {
            break;
        }
    }
    if let Some(recorder) = recorder.filter(|_| !stopped) {
        recorder.finish(&sim)?;
    }
    let mut summary = sim.summary(&spec, began.elapsed().as_secs_f64());
    summary.frames = sim.frames(&spec.frame_hash)?;
    if stopped {
        summary.outcome = RunOutcome::Stopped;
    // No step and no end: a script paused the cell. Reported as a warning, because the run
    // would otherwise look like one that reached its time limit.
    } else if !sim.is_ending() {
        let time_s = summary.sim_time_s;
        let paused = format!(
            "the script paused the cell at {time_s:.3} s, and a run in one process has no \
             operator to resume it"
        );
        on_message(RunMessage::Warning(&paused));
        summary.message.get_or_insert(paused);
    }
    report::of_replies(&summary.script_replies)
        .for_each(|text| on_message(RunMessage::Warning(&text)));
    Ok(summary)
}

/// The recording of a run whose run file names one.
fn recorder(spec: &RunSpec) -> Result<Option<Recorder>, SimError> {
    let Some(file) = &spec.record.file else {
        return Ok(None);
    };
    // Without a rate there is a state for each decision.
    let hold = Hold::new(spec.action_hz.unwrap_or(100))?;
    Ok(Some(Recorder::create(spec, file, hold)?))
}

fn report_new(sim: &mut OneProcess, on_message: &mut impl FnMut(RunMessage<'_>)) {
    for (tick, line) in sim.take_trace() {
        on_message(RunMessage::Line(tick, &line));
    }
    for warning in sim.take_warnings() {
        on_message(RunMessage::Warning(&warning));
    }
}

/// Reads a script file for `cell`.
pub fn script(path: &Path, cell: &Cell) -> Result<Vec<ScriptLine>, SimError> {
    let name = path.display().to_string();
    let text = user_file::read_text(path).map_err(|source| SimError::ScriptFile {
        path: name.clone(),
        source,
    })?;
    Ok(cell_model::cells::script::parse_for(&text, &name, cell)?)
}
