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
    format!(
        "{what}{reason} after {:.2} s simulated in {:.2} s: placed {}, {} drops, {} resyncs, {} aborts, \
         {} task restarts, {} limit violations, state {}{}",
        summary.sim_time_s,
        summary.wall_time_s,
        if summary.placed.is_empty() {
            "nothing".to_owned()
        } else {
            summary.placed.join(" ")
        },
        summary.drops,
        summary.resyncs,
        summary.aborts,
        summary.task_restarts,
        summary.limit_violations,
        summary.state_hash,
        match summary.script_left {
            0 => String::new(),
            left => format!("; {left} lines of the script were not reached"),
        }
    )
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
}
