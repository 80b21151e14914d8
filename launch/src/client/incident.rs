//! `robocell incident`: what was kept of failures, as lists and plots for a terminal.

use std::fmt::Write as _;

use cell_run::incident::{Head, Incident, Incidents, LoopTrace};
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::{Context, Failure};
use supervisor::flight;
use supervisor::rundir::RunDir;

use crate::args::IncidentArgs;
use crate::shell::quoted;
use crate::{output, say};

/// Columns of a plot.
const COLUMNS: usize = 72;
/// A value in eight steps.
const STEPS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
/// Overruns that are listed of each loop.
const LISTED: usize = 5;

/// The result of `robocell incident --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct IncidentList {
    /// Name of the cell.
    cell: String,
    /// The oldest first.
    incidents: Vec<Head>,
}

/// Lists the incidents of a cell, or prints one.
pub(crate) fn incident(args: &IncidentArgs) -> Result<(), Failure> {
    let cell = &args.cell.cell;
    let incidents = Incidents::at(flight::incidents(cell, &RunDir::of(cell)?));
    let Some(number) = args.number else {
        return list(&incidents, args);
    };
    let numbers = incidents.numbers();
    if !numbers.contains(&number) {
        let there = match (numbers.first(), numbers.last()) {
            (Some(first), Some(last)) => format!("{first} to {last} are kept"),
            _ => "none is kept".to_owned(),
        };
        return Err(Failure::configuration(format!(
            "cell `{cell}` has no incident {number}: {there}"
        )));
    }
    let path = incidents.path(number);
    let read = format!("read the incident in {}", path.display());
    if args.json {
        let bytes = incidents.bytes(number).cannot(read)?;
        say::line(String::from_utf8_lossy(&bytes));
    } else {
        let incident = incidents.load(number).cannot(read)?;
        say::line(print(&incident));
        say::line(format_args!("files: {}", path.display()));
    }
    Ok(())
}

fn list(incidents: &Incidents, args: &IncidentArgs) -> Result<(), Failure> {
    let heads = incidents.numbers().into_iter();
    // One that is just deleted, or of another version, is left out.
    let heads: Vec<_> = heads.filter_map(|n| incidents.head(n).ok()).collect();
    if args.json {
        return output::print(&IncidentList {
            cell: args.cell.cell.clone(),
            incidents: heads,
        });
    }
    if heads.is_empty() {
        say::line(format_args!(
            "No incident of cell `{}` is kept.",
            args.cell.cell
        ));
    }
    for head in heads {
        say::line(format_args!(
            "{:>4}  {}  {:<16} {:>9.3} s  {}",
            head.number, head.at, head.demo, head.sim_time_s, head.what
        ));
    }
    Ok(())
}

/// An incident for people.
fn print(incident: &Incident) -> String {
    let head = &incident.head;
    let mut out = format!(
        "Incident {}: {}\n{}, {} with policy {}, seed {}, {:.3} s of simulated time, robocell {}\n",
        head.number,
        head.what,
        head.at,
        head.demo,
        head.policy,
        head.seed,
        head.sim_time_s,
        head.version
    );
    if !head.complete {
        out.push_str("The launcher ended before the second after it was kept.\n");
    }
    out.push_str("\nEvents\n");
    for event in &incident.events {
        // Writing to a string cannot fail.
        let _ok = writeln!(out, "{:>10.1} ms  {}", event.at_ms, event.what);
    }
    let span = span(incident);
    for trace in &incident.loops {
        print_loop(&mut out, trace, span);
    }
    let marks: Vec<f64> = incident.events.iter().map(|event| event.at_ms).collect();
    print_axis(&mut out, &marks, span);
    for log in &incident.logs {
        let _ok = writeln!(out, "\nEnd of the log of {}", log.process);
        if log.lines.is_empty() {
            out.push_str("  (it wrote nothing)\n");
        }
        for line in &log.lines {
            let _ok = writeln!(out, "  {line}");
        }
    }
    let recording = quoted(&incident.recording);
    let _ok = write!(
        out,
        "\nmessages of that time: `robocell replay {recording}` (until the ring is overwritten)"
    );
    out
}

/// First and last instant of all loops (ms).
fn span(incident: &Incident) -> (f64, f64) {
    let all = incident.loops.iter().flat_map(|trace| &trace.at_ms);
    // At least 1 ms on each side: `column` divides by the width.
    let first = all.clone().copied().fold(-1.0, f64::min);
    (first, all.copied().fold(1.0, f64::max))
}

fn print_loop(out: &mut String, trace: &LoopTrace, span: (f64, f64)) {
    let cycles = trace.tick.len();
    let mut starts = trace.generation.clone();
    starts.dedup();
    let starts: Vec<String> = starts.iter().map(u16::to_string).collect();
    let _ok = writeln!(
        out,
        "\n{}: {cycles} cycles of start {}",
        trace.process,
        starts.join(", ")
    );
    if cycles == 0 {
        return;
    }
    let figures = |of: &[f64]| {
        let at = |percent| LoopTrace::percentile(of, percent);
        format!("p50 {:.0}, p99 {:.0}, max {:.0}", at(50), at(99), at(100))
    };
    let _ok = writeln!(
        out,
        "  late (us): {}; work (us): {}",
        figures(&trace.late_us),
        figures(&trace.body_us)
    );
    let causes = trace.causes();
    if !causes.is_empty() {
        let causes: Vec<_> = causes.iter().map(|(c, n)| format!("{c} {n}")).collect();
        let count = trace.overruns.len();
        let _ok = writeln!(out, "  {count} overruns: {}", causes.join(", "));
        for (index, cause) in worst(trace) {
            let _ok = writeln!(
                out,
                "  {:>8.1} ms  tick {}  late {:.0} us  work {:.0} us  {cause}",
                trace.at_ms[index], trace.tick[index], trace.late_us[index], trace.body_us[index]
            );
        }
    }
    let plots = [("late (us)", &trace.late_us), ("work (us)", &trace.body_us)];
    let values = trace.values.iter().map(|(name, of)| (name.as_str(), of));
    for (name, of) in plots.into_iter().chain(values) {
        let top = of.iter().copied().fold(0.0, f64::max);
        // A flat line says nothing.
        if of.iter().any(|value| *value != top) {
            let line = plot(&trace.at_ms, of, top, span);
            let _ok = writeln!(out, "  {line} {name}, max {}", short(top));
        }
    }
}

/// The overruns that took longest, in the order of time. An index that is not in the
/// trace, in a file changed by hand, is left out.
fn worst(trace: &LoopTrace) -> Vec<(usize, &str)> {
    let loss = |index: usize| trace.late_us[index] + trace.body_us[index];
    let valid = trace.overruns.iter().filter(|(i, _)| is_whole(trace, *i));
    let mut worst: Vec<_> = valid.map(|(i, cause)| (*i, cause.as_str())).collect();
    worst.sort_by(|a, b| loss(b.0).total_cmp(&loss(a.0)));
    worst.truncate(LISTED);
    worst.sort_by_key(|(index, _)| *index);
    worst
}

fn is_whole(trace: &LoopTrace, index: usize) -> bool {
    let lengths = [
        trace.tick.len(),
        trace.at_ms.len(),
        trace.late_us.len(),
        trace.body_us.len(),
    ];
    lengths.iter().all(|length| index < *length)
}

/// The greatest value of each column; a column without a cycle is blank.
fn plot(at_ms: &[f64], values: &[f64], top: f64, span: (f64, f64)) -> String {
    let mut greatest = [None; COLUMNS];
    for (at_ms, value) in at_ms.iter().zip(values) {
        let slot = &mut greatest[column(*at_ms, span)];
        *slot = Some(slot.map_or(*value, |old: f64| old.max(*value)));
    }
    let step = |value: f64| STEPS[clamped(value / top * 7.0, 7)];
    greatest
        .iter()
        .map(|value| value.map_or(' ', step))
        .collect()
}

/// Marks where events are, and the times of both ends.
fn print_axis(out: &mut String, marks: &[f64], span: (f64, f64)) {
    let mut line = [' '; COLUMNS];
    for at_ms in marks {
        line[column(*at_ms, span)] = '▲';
    }
    let line: String = line.iter().collect();
    let (first, last) = (format!("{:.0} ms", span.0), format!("{:.0} ms", span.1));
    let gap = COLUMNS.saturating_sub(first.len());
    let _ok = writeln!(out, "\n  {line} events\n  {first}{last:>gap$}");
}

fn column(at_ms: f64, (first, last): (f64, f64)) -> usize {
    clamped(
        (at_ms - first) / (last - first) * COLUMNS as f64,
        COLUMNS - 1,
    )
}

#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "clamped to what a plot has"
)]
fn clamped(value: f64, most: usize) -> usize {
    value.clamp(0.0, most as f64) as usize
}

fn short(value: f64) -> String {
    let digits = if value >= 100.0 { 0 } else { 3 };
    format!("{value:.digits$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_run::incident::{Event, Head, LogTail};

    fn incident() -> Incident {
        let times = 0..100_u16;
        let at_ms: Vec<f64> = times
            .clone()
            .map(|i| f64::from(i) * 40.0 - 3000.0)
            .collect();
        let late_us = times.map(|i| f64::from(i % 50)).collect();
        Incident {
            head: Head {
                number: 3,
                also: Vec::new(),
                what: "task was killed (SIGKILL)".to_owned(),
                at: "2026-01-02 03:04:05 UTC".to_owned(),
                sim_time_s: 12.5,
                run: 1,
                demo: "reach".to_owned(),
                policy: "fsm".to_owned(),
                seed: 0,
                version: "0.1.0".to_owned(),
                complete: true,
            },
            events: vec![Event {
                at_ms: 0.0,
                what: "task was killed (SIGKILL)".to_owned(),
            }],
            loops: vec![LoopTrace {
                process: "task".to_owned(),
                generation: vec![1; 100],
                tick: (0..100).collect(),
                body_us: vec![10.0; 100],
                overruns: vec![(49, "preemption".to_owned()), (700, "wake-up".to_owned())],
                values: [("outcome".to_owned(), vec![0.0; 100])].into(),
                at_ms,
                late_us,
            }],
            logs: vec![LogTail {
                process: "task".to_owned(),
                lines: vec!["its last line".to_owned()],
            }],
            recording: "ring".into(),
        }
    }

    #[test]
    fn an_incident_is_printed_with_its_overruns_plots_and_log() {
        let text = print(&incident());
        for part in [
            "Incident 3: task was killed (SIGKILL)",
            "12.500 s of simulated time",
            "0.0 ms  task was killed",
            "task: 100 cycles of start 1",
            "late (us): p50 24, p99 49, max 49; work (us): p50 10",
            "2 overruns: preemption 1, wake-up 1",
            "-1040.0 ms  tick 49  late 49 us  work 10 us  preemption",
            "its last line",
        ] {
            assert!(text.contains(part), "{part} in:\n{text}");
        }
        // What does not change is not drawn.
        assert!(!text.contains("outcome, max"), "{text}");
        let plot = text.lines().find(|line| line.contains("late (us), max"));
        let plot = plot.unwrap();
        assert!(plot.contains('█') && plot.contains('▁'), "{plot}");
        assert_eq!(text.matches('▲').count(), 1);
    }
}
