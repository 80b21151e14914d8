//! What `run` tells a person.

use std::path::{Path, PathBuf};

use cell_run::spec::{RecordSpec, RunSpec};
use cell_run::summary::RunSummary;
use ipc_types::health::Scheduling;
use supervisor::run::LiveCell;
use supervisor::run::plan::title;
use supervisor::rundir::DEFAULT_CELL;

use super::first_page;
use crate::say;
use crate::shell::quoted;

/// The run and its arms.
pub(super) fn announce(live: &LiveCell, about_arms: &[String]) {
    say::line(title(live.spec()));
    about_arms.iter().for_each(say::line);
}

/// ` --cell NAME` for commands about the cell; empty for the default name.
pub(super) fn cell_option(spec: &RunSpec) -> String {
    if spec.cell == DEFAULT_CELL {
        String::new()
    } else {
        format!(" --cell {}", spec.cell)
    }
}

/// The files of the recording of a run that has ended, and the number of missing messages. A
/// recorder that was restarted continues in another file. Empty if no recording is left.
pub(super) fn recording(spec: &RecordSpec, summary: &RunSummary) -> Vec<String> {
    let mut lines = files(spec, &summary.record_files);
    if summary.record_gaps > 0 && !lines.is_empty() {
        lines.push(format!(
            "the recording misses {} messages; its channel `gaps` has their times",
            summary.record_gaps
        ));
    }
    lines
}

fn files(spec: &RecordSpec, parts: &[PathBuf]) -> Vec<String> {
    let line = |what: &str, path: &Path| {
        let shell = quoted(path);
        let path = path.display();
        format!("{what}: {path} (`robocell replay {shell}` shows it)")
    };
    let file = spec.file.iter().filter(|file| !parts.contains(file));
    let there: Vec<_> = file.chain(parts).filter(|file| file.is_file()).collect();
    if let [file] = there[..] {
        return vec![line("recording", file)];
    }
    let numbered = there.iter().enumerate();
    let lines: Vec<_> = numbered
        .map(|(index, file)| {
            let (part, of) = (index + 1, there.len());
            line(&format!("recording, part {part} of {of}"), file)
        })
        .collect();
    let flight = spec.flight_dir.as_path();
    let is_there = || std::fs::read_dir(flight).is_ok_and(|mut all| all.next().is_some());
    if lines.is_empty() && is_there() {
        return vec![line("recording of the last minutes", flight)];
    }
    lines
}

/// The processes, and what to do next.
pub(crate) fn ready(live: &LiveCell, waits_for_page: bool) {
    let mut real_time = true;
    for (process, pid) in live.pids() {
        let pid = pid.map_or_else(|| "-".to_owned(), |pid| pid.to_string());
        let health = live.watch().health(process);
        let fifo = health.is_some_and(|h| h.scheduling == Scheduling::Fifo.code());
        // Only physics and controllers have cycles of 1 ms.
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
