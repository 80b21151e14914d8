//! `robocell bench e2e`: how old the state is when its command is applied.
//!
//! A private cell runs in real time; physics measures the age of the state a command was
//! computed from when it applies that command, and controllers measure the lateness of their
//! cycles. Both report figures over the last second; printed are their medians and the worst
//! second. Then the task is killed repeatedly: the time until the next one decides.

mod answers;
mod kills;

use std::path::Path;

use crate::report::{Report, Row};
use cell_rt::clock::monotonic_ns;
use ipc_types::Health;
use ipc_types::health::Scheduling;
use ipc_types::topic::Process;

use kills::{Kills, Observation, strike};
use launch::args::{Cli, Command};
use supervisor::failure::Failure;
use supervisor::run::plan::Plan;
use supervisor::run::{End, LiveCell};

/// Demo of the bench.
const DEMO: &str = "franka-stack";
/// Figures of the first second include the start.
pub(crate) const WARM_UP_NS: u64 = 1_500_000_000;
/// Interval of the samples of the per-second figures.
pub(crate) const WINDOW_NS: u64 = 1_000_000_000;

/// p50, p99 and max of each second.
#[derive(Debug, Default)]
pub(crate) struct Series(pub(crate) Vec<[f64; 3]>);

impl Series {
    /// Medians over the seconds, and the p99 and the maximum of the worst one.
    pub(crate) fn row(&self, name: String) -> Row {
        let column = |k: usize| {
            let mut values: Vec<f64> = self.0.iter().map(|second| second[k] * 1.0e-3).collect();
            values.sort_by(f64::total_cmp);
            values
        };
        let median = |values: &[f64]| values.get(values.len() / 2).copied().unwrap_or(0.0);
        let worst = |values: &[f64]| values.last().copied().unwrap_or(0.0);
        let (p50, p99, max) = (column(0), column(1), column(2));
        let figures = [median(&p50), median(&p99), worst(&p99), worst(&max)];
        Row::new(name, self.0.len(), figures)
    }
}

#[derive(Default)]
struct Probe {
    next_ns: u64,
    fifo: bool,
    apply: Series,
    physics: Series,
    controller: Series,
}

impl Probe {
    fn observe(&mut self, now: u64, live: &LiveCell) {
        if now < self.next_ns {
            return;
        }
        self.next_ns = now + WINDOW_NS;
        let watch = live.watch();
        let (Some(physics), Some(controller)) = (
            watch.health(Process::Physics),
            watch.health(Process::Controller(0)),
        ) else {
            return;
        };
        self.fifo = physics.scheduling == Scheduling::Fifo.code();
        // The age has no maximum; the p99 of the worst second is used instead.
        self.apply.0.push([
            physics.apply_age_p50_ns,
            physics.apply_age_p99_ns,
            physics.apply_age_p99_ns,
        ]);
        self.physics.0.push(lateness(physics));
        self.controller.0.push(lateness(controller));
    }
}

/// Lateness of the cycles of the last second (ns): p50, p99 and maximum.
pub(crate) fn lateness(health: &Health) -> [f64; 3] {
    [
        health.lateness_p50_ns,
        health.lateness_p99_ns,
        health.lateness_max_ns,
    ]
}

/// Measures for `seconds` and prints.
pub(crate) fn run(seconds: f64, json: bool) -> Result<(), Failure> {
    let cell = format!("bench-{}", std::process::id());
    let live = LiveCell::start(plan(&cell)?)?;
    let flight_dir = live.spec().record.flight_dir.clone();
    let (mut probe, mut kills) = (Probe::default(), Kills::default());
    let mut until = None;
    let end = live.stay(|live| {
        let now = monotonic_ns();
        if !live.is_ready() {
            // Counted from the moment at which all processes are up.
            return;
        }
        // The first window would contain the start.
        let end_ns = *until.get_or_insert_with(|| {
            probe.next_ns = now + WARM_UP_NS;
            now + WARM_UP_NS + nanos(seconds)
        });
        if now < end_ns {
            probe.observe(now, live);
        } else if kills.update(now, &observe(live), strike) {
            live.stop();
        }
    });
    if let End::GaveUp(failure) = end {
        return Err(failure);
    }
    print(&probe, kills, &flight_dir, json)
}

/// The present state of the task.
fn observe(live: &LiveCell) -> Observation {
    let mut pids = live.pids().into_iter();
    let pid = pids.find(|(process, _)| *process == Process::Task);
    let pid = pid.and_then(|(_, pid)| pid);
    // The health of the process with this pid, if it has published one.
    // A new pid is known before the health of its process.
    let health = live.watch().health(Process::Task);
    let health = health.filter(|health| Some(health.pid) == pid);
    let decision = live.watch().decision().map(|decision| decision.header);
    Observation {
        task: health.map(|health| (health.pid, health.header.generation)),
        decision: decision.map_or((0, 0), |header| (header.generation, header.publish_ns)),
    }
}

/// In nanoseconds.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the command line allows up to 1e6 s"
)]
pub(crate) fn nanos(seconds: f64) -> u64 {
    (seconds * 1.0e9) as u64
}

/// A real-time run of a cell of this name.
pub(crate) fn plan(cell: &str) -> Result<Plan, Failure> {
    use clap::Parser;
    // By way of the command line, so that the bench runs exactly what a user runs.
    let cli = Cli::try_parse_from(["robocell", "run", DEMO, "--headless", "--cell", cell])
        .map_err(Failure::usage)?;
    match &cli.command {
        Command::Run(args) => launch::run::resolve(args),
        _ => Err(Failure::usage("the bench starts a run")),
    }
}

fn print(probe: &Probe, kills: Kills, flight_dir: &Path, json: bool) -> Result<(), Failure> {
    let note = "lateness and age: medians over seconds; p99.9: p99 of the worst second".to_owned();
    let mut report = Report::new("e2e", probe.fifo, &[note]);
    match answers::answers(flight_dir) {
        Ok(samples) => report.draw("from a state to its command", &samples),
        // The figures are worth printing without it.
        Err(error) => report
            .notes
            .push(format!("no histogram of states: {error}")),
    }
    report.draw("task killed to its next decision", kills.waits());
    report.rows = vec![
        probe
            .apply
            .row("state age when its command is applied".to_owned()),
        probe.controller.row("controller lateness".to_owned()),
        probe.physics.row("physics lateness".to_owned()),
        kills.into_row(),
    ];
    report
        .write(&mut std::io::stdout().lock(), json)
        .map_err(Failure::configuration)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_is_the_median_second_and_the_worst_one() {
        let series = Series(vec![[1e3, 5e3, 9e3], [3e3, 6e3, 8e3], [2e3, 40e3, 90e3]]);
        let row = series.row("x".to_owned());
        assert_eq!(
            (row.n, row.p50, row.p99, row.p999, row.max),
            (3, 2.0, 6.0, 40.0, 90.0)
        );
        assert_eq!(Series::default().row("none".to_owned()).n, 0);
    }
}
