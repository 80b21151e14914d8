//! What `run` tells a person.

use cell_model::runs::spec::{RecordSpec, RunSpec, Speed};
use ipc_types::health::Scheduling;

use super::{LiveCell, first_page};
use crate::say;

/// `franka-stack, policy fsm, seed 0, real time (cell `cell`)`.
pub(crate) fn title(spec: &RunSpec) -> String {
    let speed = match spec.speed {
        Speed::RealTime => "real time".to_owned(),
        Speed::Max => "lockstep, as fast as it goes".to_owned(),
        Speed::Factor(factor) => format!("lockstep, {factor} times real time"),
    };
    format!(
        "{}, policy {}, seed {}, {speed} (cell `{}`)",
        spec.demo, spec.policy, spec.seed, spec.cell
    )
}

/// ` --cell NAME` for commands about the cell; empty for the default name.
pub(super) fn cell_option(spec: &RunSpec) -> String {
    if spec.cell == crate::cli_common::DEFAULT_CELL {
        String::new()
    } else {
        format!(" --cell {}", spec.cell)
    }
}

/// Where the run is recorded, once it has ended; nothing where no recording is left.
pub(super) fn recording(spec: &RecordSpec) -> Option<String> {
    let file = spec.file.as_deref().filter(|file| file.is_file());
    let (what, path) = match file {
        Some(file) => ("recording", file),
        None => ("recording of the last minutes", spec.flight_dir.as_path()),
    };
    let is_there =
        file.is_some() || std::fs::read_dir(path).is_ok_and(|mut all| all.next().is_some());
    let path = path.display();
    is_there.then(|| format!("{what}: {path} (`robocell replay {path}` shows it)"))
}

/// The processes, and what to do next.
pub(crate) fn ready(live: &LiveCell, waits_for_page: bool) {
    let mut real_time = true;
    for (process, pid) in live.pids() {
        let pid = pid.map_or_else(|| "-".to_owned(), |pid| pid.to_string());
        let health = live.watch().health(process);
        let fifo = health.is_some_and(|h| h.scheduling == Scheduling::Fifo.code());
        let is_fast = !matches!(
            process,
            ipc_types::topic::Process::Task | ipc_types::topic::Process::Monitor
        );
        real_time &= fifo || !is_fast;
        let class = if fifo { "real-time scheduling" } else { "" };
        say::line(format!("  {:<14} pid {pid:<8} {class}", process.name()).trim_end());
    }
    let spec = live.spec();
    if spec.real_time && !real_time {
        say::warn(
            "no real-time scheduling was granted: expect late cycles; `robocell doctor` says how to get it",
        );
    }
    let cell = cell_option(spec);
    if waits_for_page {
        let limit = first_page::PATIENCE.as_secs();
        say::line(format_args!(
            "waiting for: the page, at most {limit} s (open the link above)"
        ));
    } else if spec.paused {
        say::line(format_args!("waiting for: `robocell resume{cell}`"));
    }
    say::line(format_args!(
        "Ctrl-C stops it. From another terminal, with `robocell ...{cell}`:\n  \
         top | status | logs -f | pause | resume | step N | reset | restart task | down\n  \
         drag OBJECT --to X Y Z | task start | task pause | target X Y Z | gripper open"
    ));
}
