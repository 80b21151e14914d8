//! Start of an episode: in the same process, or in a new one.

use std::hint::black_box;
use std::process::{Command, Stdio};

use cell_model::Data;
use cell_rt::monotonic_ns;
use cell_run::spec::RunSpec;
use cell_sim::OneProcess;
use cell_sim::eval::template;
use ipc_types::operator::OperatorAction;
use ipc_types::{OperatorRequest, Wire};

use super::{DEMO, program};
use crate::error::FleetError;
use crate::report::{Report, Samples};

/// The smallest cell, and the one of the other rows.
const DEMOS: [&str; 2] = ["reach", DEMO];
/// Turns through all ways per second of `--seconds`, and at most.
const TURNS_PER_SECOND: f64 = 6.0;
const MOST_TURNS: f64 = 60.0;
/// Ticks of a cell before it is reset.
const TICKS: usize = 200;

/// Adds a row for each way of each cell.
pub(super) fn run(report: &mut Report, seconds: f64) -> Result<(), FleetError> {
    for demo in DEMOS {
        ways(
            report,
            demo,
            (seconds * TURNS_PER_SECOND).clamp(2.0, MOST_TURNS),
        )?;
    }
    Ok(())
}

fn ways(report: &mut Report, demo: &str, turns: f64) -> Result<(), FleetError> {
    let mut spec = template(demo, "");
    spec.policy = spec.load_cell_from(&Data::checkout())?.default_policy;
    let mut sim = fresh(&spec)?;
    let snapshot = sim.snapshot()?;
    let mut ways = [
        "reset in place",
        "snapshot taken back",
        "another seed",
        "new process",
    ]
    .map(|way| (format!("{demo}, start: {way}"), Samples::default()));
    let mut turn = 0.0;
    while turn < turns {
        turn += 1.0;
        // Another seed each turn, or the last way could use what the first has cached.
        spec.seed += 1;
        let [(_, reset), (_, restored), (_, seeded), (_, started)] = &mut ways;
        // Moved first: a reset of a cell at its start would have nothing to do.
        advance(&mut sim)?;
        let began_ns = monotonic_ns();
        reset_in_place(&mut sim)?;
        reset.record(monotonic_ns().saturating_sub(began_ns));
        advance(&mut sim)?;
        let began_ns = monotonic_ns();
        sim.restore(&snapshot)?;
        restored.record(monotonic_ns().saturating_sub(began_ns));
        let began_ns = monotonic_ns();
        // Created and dropped within the measurement: both belong to a restart.
        black_box(fresh(&spec)?);
        seeded.record(monotonic_ns().saturating_sub(began_ns));
        let began_ns = monotonic_ns();
        new_process(demo, spec.seed)?;
        started.record(monotonic_ns().saturating_sub(began_ns));
    }
    let names = ways.each_ref().map(|(name, _)| name.clone());
    report
        .rows
        .extend(ways.map(|(name, samples)| samples.into_row(name)));
    for name in names.iter().take(3) {
        report.compare(name, &names[3]);
    }
    Ok(())
}

/// The cell of a seed, read from its file.
fn fresh(spec: &RunSpec) -> Result<OneProcess, FleetError> {
    let cell = spec.load_cell_from(&Data::checkout())?;
    Ok(OneProcess::new(&demos::policies(), spec, cell)?)
}

fn advance(sim: &mut OneProcess) -> Result<(), FleetError> {
    for _ in 0..TICKS {
        sim.tick()?;
    }
    Ok(())
}

/// Physics resets with the request; controllers and the task see it in the next tick.
fn reset_in_place(sim: &mut OneProcess) -> Result<(), FleetError> {
    let mut request = OperatorRequest::zeroed();
    request.action = OperatorAction::Reset.code();
    sim.answer_request(&request);
    sim.tick()?;
    Ok(())
}

/// `robocell run` with one tick.
fn new_process(demo: &str, seed: u64) -> Result<(), FleetError> {
    let seed = seed.to_string();
    let words = ["run", demo, "--one-process", "--timeout", "0.001"];
    let path = program()?;
    let mut command = Command::new(&path);
    command.args(words).args(["--seed", &seed]);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    // It ends like a run that was out of time.
    match command.status() {
        Ok(_) => Ok(()),
        Err(source) => Err(FleetError::Program { path, source }),
    }
}
