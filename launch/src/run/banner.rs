//! What `run` tells a person.

use cell_model::runs::spec::{RunSpec, Speed};
use cell_model::runs::summary::{RunOutcome, RunSummary};
use ipc_types::health::Scheduling;

use super::LiveCell;
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

/// The processes, and what to do next.
pub(crate) fn ready(live: &LiveCell) {
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
    let cell = if spec.cell == crate::cli_common::DEFAULT_CELL {
        String::new()
    } else {
        format!(" --cell {}", spec.cell)
    };
    if spec.paused {
        say::line(format_args!("Paused: `robocell resume{cell}` starts it."));
    }
    say::line(format_args!(
        "Ctrl-C stops it. From another terminal, with `robocell ...{cell}`:\n  \
         top | status | logs -f | pause | resume | step N | reset | restart task | down\n  \
         drag OBJECT --to X Y Z | task start | task pause | target X Y Z | gripper open"
    ));
}

/// The summary in one line.
pub(crate) fn outcome(summary: &RunSummary) -> String {
    let what = match summary.outcome {
        RunOutcome::Done => "done",
        RunOutcome::Failed => "failed",
        RunOutcome::Timeout => "out of time",
    };
    let reason = summary
        .reason
        .as_ref()
        .map(|r| format!(" ({r})"))
        .unwrap_or_default();
    let mut parts = Vec::new();
    if !summary.placed.is_empty() {
        parts.push(format!("placed {}", summary.placed.join(" ")));
    }
    parts.push(recoveries(summary));
    parts.extend(many(summary.task_restarts, "task restart", "task restarts"));
    parts.push(format!("{} limit violations", summary.limit_violations));
    parts.push(format!("state {}", summary.state_hash));
    let left = many(summary.script_left, "line", "lines");
    parts.extend(left.map(|lines| format!("{lines} of the script were not reached")));
    format!(
        "{what}{reason} after {:.2} s simulated in {:.2} s: {}",
        summary.sim_time_s,
        summary.wall_time_s,
        parts.join("; ")
    )
}

/// What had to be done again.
fn recoveries(summary: &RunSummary) -> String {
    let counts = [
        many(summary.drops, "drop", "drops"),
        many(summary.resyncs, "resync", "resyncs"),
        many(summary.aborts, "abort", "aborts"),
        many(summary.recoveries, "other recovery", "other recoveries"),
    ];
    let counts: Vec<String> = counts.into_iter().flatten().collect();
    match (counts.is_empty(), summary.outcome) {
        (true, _) => "nothing had to be recovered".to_owned(),
        (false, RunOutcome::Done) => format!("recovered from {}", counts.join(", ")),
        (false, _) => counts.join(", "),
    }
}

/// A count with its word; nothing for none.
fn many(count: u32, one: &str, more: &str) -> Option<String> {
    match count {
        0 => None,
        1 => Some(format!("1 {one}")),
        _ => Some(format!("{count} {more}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use cell_model::runs::summary::RunFacts;
    use ipc_types::{Decision, Wire, WorldState};

    #[test]
    fn lines_of_a_script_that_never_came_are_said() {
        let facts = RunFacts {
            demo: "reach",
            policy: "follow",
            seed: 0,
            objects: &[],
            wall_time_s: 1.0,
            task_restarts: 0,
            missed_cycles: 0,
        };
        let mut state = WorldState::zeroed();
        let said =
            |state: &WorldState| outcome(&RunSummary::new(&facts, state, &Decision::zeroed()));
        assert!(!said(&state).contains("script"));
        state.script_left = 2;
        assert!(said(&state).contains("; 2 lines of the script were not reached"));
    }

    #[test]
    fn what_was_recovered_from_is_counted_and_does_not_read_as_a_failure() {
        let facts = RunFacts {
            demo: "ur10-fill-bin",
            policy: "matrix",
            seed: 0,
            objects: &[],
            wall_time_s: 1.0,
            task_restarts: 1,
            missed_cycles: 0,
        };
        let mut decision = Decision::zeroed();
        let said = |decision: &Decision| {
            let mut summary = RunSummary::new(&facts, &WorldState::zeroed(), decision);
            summary.outcome = RunOutcome::Done;
            outcome(&summary)
        };
        assert!(said(&decision).contains(": nothing had to be recovered; 1 task restart; "));
        (decision.drops, decision.recoveries) = (1, 2);
        let text = said(&decision);
        assert!(
            text.contains(": recovered from 1 drop, 2 other recoveries; "),
            "{text}"
        );
        assert!(!text.contains("nothing"), "{text}");
    }
}
