//! `robocell status`.

use cell_model::Cell;
use ipc_types::decision::Outcome;
use ipc_types::health::Scheduling;
use ipc_types::world::{FLAG_PAUSED, PauseCause};
use ipc_types::{Decision, WorldState};
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::Failure;

use super::columns::terminal_width;
use super::picture::Picture;
use super::process_table::{self, ProcessStatus};
use super::scene::{self, ArmReport, ObjectReport};
use super::session::Session;
use super::top::equipment::Names;
use crate::args::ReportArgs;
use crate::{output, say};

/// How a cell is doing: the result of `robocell status --json`.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct Status {
    cell: String,
    demo: String,
    /// Name of the policy that works.
    policy: String,
    seed: u64,
    /// Process id of the launcher.
    pid: u32,
    /// Wall clock, UTC.
    since: String,
    /// Link to the page, for who may command.
    page: Option<String>,
    paused: bool,
    /// `start`, `operator`, `step` or `breakpoint`; none while it is not paused.
    pause_cause: Option<&'static str>,
    /// Name of the breakpoint that paused it: a node, state or guard of the task.
    breakpoint: Option<String>,
    /// None while physics publishes nothing.
    tick: Option<u64>,
    sim_time_s: Option<f64>,
    /// Simulated time in a second, of the last second.
    real_time_factor: Option<f64>,
    /// `idle`, `running`, `done`, `failed` or `paused`; none while the task publishes nothing.
    outcome: Option<String>,
    phase: Option<String>,
    /// Stable name of the reason, if any.
    reason: Option<String>,
    /// What an arm has been waiting for, if any.
    wait: Option<String>,
    /// Objects in place, by name.
    placed: Vec<String>,
    drops: u32,
    resyncs: u32,
    aborts: u32,
    recoveries: u32,
    limit_violations: u64,
    processes: Vec<ProcessStatus>,
    arms: Vec<ArmReport>,
    /// Those that are in the cell.
    objects: Vec<ObjectReport>,
    conveyor: Option<Conveyor>,
    /// The equipment, for people.
    #[serde(skip)]
    equipment: Vec<String>,
}

/// A conveyor.
#[derive(Debug, Serialize, JsonSchema)]
struct Conveyor {
    speed_m_s: f64,
    bins_supplied: u32,
    /// The command it waits for.
    waits_for: Option<&'static str>,
}

/// Prints how the cell is doing.
pub(crate) fn status(args: &ReportArgs) -> Result<(), Failure> {
    let session = Session::of(&args.cell.cell)?;
    let mut picture = Picture::open(&session)?;
    picture.fill();
    let cell = session.spec.load_cell().map_err(Failure::configuration)?;
    let status = describe(&session, &picture, &cell);
    if args.json {
        return output::print(&status);
    }
    print(&status);
    Ok(())
}

/// A task's outcome in one word.
pub(crate) fn word(outcome: u32) -> String {
    let known = Outcome::from_code(outcome).map(|o| format!("{o:?}").to_lowercase());
    known.unwrap_or_else(|| format!("outcome {outcome}"))
}

/// What a task in that outcome waits for, for people.
pub(crate) fn waits_for(outcome: &str) -> &'static str {
    match outcome {
        "idle" => ", waits for `robocell task start`",
        "paused" => ", waits for `robocell task resume`",
        _ => "",
    }
}

pub(super) fn describe(session: &Session, picture: &Picture, cell: &Cell) -> Status {
    let (state, decision) = (picture.state(), picture.decision());
    let idle = decision.is_some_and(|d| d.outcome == Outcome::Idle.code());
    let conveyor = |state: &WorldState| Conveyor {
        speed_m_s: state.equipment.conveyor_speed,
        bins_supplied: state.equipment.bins_supplied,
        waits_for: (idle && state.equipment.conveyor_speed == 0.0).then_some("task start"),
    };
    let spec = &session.spec;
    // Not from the run file: `restart task --policy` changes it before the old task has ended.
    let policy = decision
        .map(|d| d.policy.as_str().to_owned())
        .filter(|p| !p.is_empty());
    Status {
        cell: spec.cell.clone(),
        demo: spec.demo.clone(),
        policy: policy.unwrap_or_else(|| spec.policy.clone()),
        seed: spec.seed,
        pid: session.holder.pid,
        since: session.holder.since.clone(),
        page: spec.page.as_ref().and_then(crate::page::link),
        paused: state.is_some_and(|s| s.has(FLAG_PAUSED)),
        pause_cause: state.and_then(pause_cause),
        breakpoint: breakpoint(state, decision),
        tick: state.map(|s| s.header.tick),
        sim_time_s: state.map(|s| s.header.sim_time_ns as f64 / 1.0e9),
        real_time_factor: picture.real_time_factor(),
        outcome: decision.map(|d| word(d.outcome)),
        phase: decision.map(|d| d.phase.as_str().to_owned()),
        reason: decision
            .map(|d| d.reason.as_str().to_owned())
            .filter(|r| !r.is_empty()),
        wait: decision
            .map(|d| d.wait.as_str().to_owned())
            .filter(|w| !w.is_empty()),
        placed: decision.map_or_else(Vec::new, |d| placed(cell, d)),
        drops: decision.map_or(0, |d| d.drops),
        resyncs: decision.map_or(0, |d| d.resyncs),
        aborts: decision.map_or(0, |d| d.aborts),
        recoveries: decision.map_or(0, |d| d.recoveries),
        limit_violations: state.map_or(0, |s| s.arms().iter().map(|a| a.limit_violations).sum()),
        processes: processes(picture),
        arms: state.map_or_else(Vec::new, |s| scene::arms(cell, s, &picture.said())),
        objects: state.map_or_else(Vec::new, |s| scene::objects(cell, s)),
        conveyor: state.filter(|_| cell.conveyor.is_some()).map(conveyor),
        equipment: state.map_or_else(Vec::new, |s| Names::of(cell).lines(&s.equipment)),
    }
}

fn pause_cause(state: &WorldState) -> Option<&'static str> {
    let cause = PauseCause::from_code(state.panel.pause_cause);
    match cause.filter(|_| state.has(FLAG_PAUSED))? {
        PauseCause::Start => Some("start"),
        PauseCause::Operator => Some("operator"),
        PauseCause::Step => Some("step"),
        PauseCause::Breakpoint => Some("breakpoint"),
        PauseCause::None => None,
    }
}

/// Name of the breakpoint that paused the cell: physics knows only that one did, the
/// task says which.
pub(super) fn breakpoint(
    state: Option<&WorldState>,
    decision: Option<&Decision>,
) -> Option<String> {
    let at_break = PauseCause::Breakpoint.code();
    let state = state.filter(|s| s.has(FLAG_PAUSED) && s.panel.pause_cause == at_break);
    let name = state.and(decision)?.break_name.as_str();
    (!name.is_empty()).then(|| name.to_owned())
}

/// Names of the objects in place.
fn placed(cell: &Cell, decision: &Decision) -> Vec<String> {
    let count = (decision.placed_count as usize).min(decision.placed.len());
    let name = |index: &u32| Some(cell.objects.get(*index as usize)?.name.clone());
    decision.placed[..count].iter().filter_map(name).collect()
}

pub(super) fn processes(picture: &Picture) -> Vec<ProcessStatus> {
    let describe = |(process, health): (ipc_types::topic::Process, Option<&ipc_types::Health>)| {
        ProcessStatus {
            name: process.name(),
            pid: health.map(|h| h.pid),
            generation: health.map(|h| h.header.generation),
            scheduling: health.map(|h| {
                if h.scheduling == Scheduling::Fifo.code() {
                    "fifo"
                } else {
                    "other"
                }
            }),
            rate_hz: health.map(|h| h.rate_hz),
            late_p50_us: health.map(|h| h.lateness_p50_ns * 1.0e-3),
            late_p99_us: health.map(|h| h.lateness_p99_ns * 1.0e-3),
            missed_cycles: health.map(|h| h.missed_cycles),
            refused: health.map(|h| h.rejected),
            note: health
                .map(|h| h.note.as_str().to_owned())
                .filter(|n| !n.is_empty()),
        }
    };
    picture.healths().map(describe).collect()
}

/// `, paused by breakpoint LIFT`; nothing while it is not paused.
fn pause(status: &Status) -> String {
    match &status.breakpoint {
        Some(name) => format!(", paused by breakpoint {name}"),
        None if status.paused => ", paused".to_owned(),
        None => String::new(),
    }
}

/// `, 0.98 x real time`; nothing where it is not known.
pub(super) fn pace(factor: Option<f64>) -> String {
    factor.map_or_else(String::new, |factor| format!(", {factor:.2} x real time"))
}

fn print(status: &Status) {
    let pause = pause(status);
    let time = status
        .sim_time_s
        .map_or_else(|| "no state of physics".to_owned(), |t| format!("{t:.3} s"));
    let pace = pace(status.real_time_factor);
    say::line(format_args!(
        "cell `{}`: {}, policy {}, seed {}, {time}{pace}{pause}; launcher pid {} since {}",
        status.cell, status.demo, status.policy, status.seed, status.pid, status.since
    ));
    if let Some(page) = &status.page {
        say::line(format_args!("page: {page}"));
    }
    let outcome = status.outcome.as_deref().unwrap_or("no decision");
    let waits = waits_for(outcome);
    let reason = status
        .reason
        .as_ref()
        .map(|r| format!(" ({r})"))
        .unwrap_or_default();
    say::line(format_args!(
        "task: {outcome}{waits}{reason}, phase {}, {} placed, {} drops, {} resyncs, {} aborts; {} limit violations",
        status.phase.as_deref().unwrap_or("-"),
        status.placed.len(),
        status.drops,
        status.resyncs,
        status.aborts,
        status.limit_violations
    ));
    if let Some(wait) = &status.wait {
        say::line(format_args!("waiting: {wait}"));
    }
    status.arms.iter().for_each(say::line);
    let waits = |conveyor: &Conveyor| conveyor.waits_for;
    if let Some(command) = status.conveyor.as_ref().and_then(waits) {
        say::line(format_args!(
            "conveyor: waits for `robocell {command}` (Perform Task on the page)"
        ));
    }
    status.equipment.iter().for_each(say::line);
    if !status.objects.is_empty() {
        say::line("objects:");
        status.objects.iter().for_each(say::line);
    }
    let lines = process_table::lines(&status.processes, terminal_width());
    lines.iter().for_each(say::line);
}

#[cfg(test)]
mod tests {
    use ipc_types::{BreakName, Wire as _};

    use super::*;

    #[test]
    fn a_breakpoint_is_named_only_while_it_is_what_pauses() {
        let (mut state, mut decision) = (WorldState::zeroed(), Decision::zeroed());
        decision.break_name = BreakName::new("LIFT");
        let look = |state: &WorldState, decision| {
            let name = breakpoint(Some(state), Some(decision));
            (pause_cause(state), name)
        };
        // The task keeps the name of the last breakpoint when the cell works again.
        assert_eq!(look(&state, &decision), (None, None));
        state.flags = FLAG_PAUSED;
        state.panel.pause_cause = PauseCause::Operator.code();
        assert_eq!(look(&state, &decision), (Some("operator"), None));
        state.panel.pause_cause = PauseCause::Breakpoint.code();
        let named = (Some("breakpoint"), Some("LIFT".to_owned()));
        assert_eq!(look(&state, &decision), named);
    }
}
