//! Health of all processes, as sent to the page four times a second (docs/page-protocol.md,
//! `status`).

use ipc_types::decision::Outcome;
use ipc_types::equipment::{BreakCause, BreakLimit, SuctionRefusal, SupplyRefusal};
use ipc_types::health::Scheduling;
use ipc_types::topic::Process;
use ipc_types::world::{FLAG_LOCKSTEP, PauseCause};
use ipc_types::{ArmState, Decision, GripperState, Health, WorldState};
use serde_json::{Value, json};

/// Content of a status.
#[derive(Clone, Copy)]
pub struct StatusInput<'a> {
    /// Every process with its health, unless it is silent.
    pub processes: &'a [(Process, Option<&'a Health>)],
    /// Cause of each process's last missed cycles, if known.
    pub missed: &'a [String],
    /// The world.
    pub world: Option<&'a WorldState>,
    /// Last decision of the task.
    pub decision: Option<&'a Decision>,
    /// Names of the objects in the order of the cell file.
    pub objects: &'a [String],
    /// Count of each breakpoint since this monitor started, by name.
    pub breaks: &'a [(String, u64)],
    /// Policy of the run, for a task without its own.
    pub policy: &'a str,
}

/// The message without the part of the recorder.
pub fn status(input: &StatusInput<'_>) -> Value {
    let why = |at: usize| input.missed.get(at).map_or("", String::as_str);
    let processes = input.processes.iter().enumerate();
    let processes: Vec<Value> = processes
        .map(|(at, (p, h))| process(*p, *h, why(at)))
        .collect();
    json!({
        "t": "status",
        "processes": processes,
        "task": task(input),
        "pause_cause": input.world.map_or("", pause_cause),
        "pause_detail": pause_detail(input),
        "speed": input.world.map(|world| speed_text(world.panel.speed)),
        "breaks": breaks(input.breaks),
        "equipment": input.world.map(|world| equipment(world, input.objects)),
        // Filled in by the publisher; with these defaults a page of a replay shows "off".
        "latency": [],
        "recorder": {
            "state": "off", "bytes": 0, "limit_bytes": 0, "file": null, "gaps": 0, "note": "",
        },
        "rt": scheduling_of_run(input),
    })
}

/// The part of a status that belongs to a moment of the past.
pub fn past(input: &StatusInput<'_>) -> Value {
    json!({
        "task": task(input),
        "equipment": input.world.map(|world| equipment(world, input.objects)),
    })
}

/// Cause of the pause of simulated time; empty if not paused.
fn pause_cause(world: &WorldState) -> &'static str {
    match PauseCause::from_code(world.panel.pause_cause) {
        Some(PauseCause::Start) => "start",
        Some(PauseCause::Operator) => "operator",
        Some(PauseCause::Step) => "step",
        Some(PauseCause::Breakpoint) => "breakpoint",
        Some(PauseCause::None) | None => "",
    }
}

/// A speed as it is written on the command line.
pub(crate) fn speed_text(factor: f64) -> String {
    if factor == 0.0 {
        "max".to_owned()
    } else {
        factor.to_string()
    }
}

/// Detail of the pause, for people; empty if the cause is enough.
fn pause_detail<'a>(input: &StatusInput<'a>) -> &'a str {
    let at_break = PauseCause::Breakpoint.code();
    let paused = input.world.is_some_and(|w| w.panel.pause_cause == at_break);
    let decision = input.decision.filter(|_| paused);
    decision.map_or("", |decision| decision.break_name.as_str())
}

fn breaks(breaks: &[(String, u64)]) -> Value {
    let reached = breaks.iter();
    reached
        .map(|(name, hits)| json!({ "name": name, "hits": hits }))
        .collect()
}

fn process(process: Process, health: Option<&Health>, missed_why: &str) -> Value {
    let figure = |of: fn(&Health) -> f64| health.map_or(0.0, of);
    let count = |of: fn(&Health) -> u64| health.map_or(0, of);
    json!({
        "name": process.name(),
        "state": if health.is_some() { "running" } else { "silent" },
        "pid": health.map(|h| h.pid),
        "generation": health.map(|h| h.header.generation),
        "scheduling": health.map(scheduling),
        "rate_hz": figure(|h| h.rate_hz),
        "late_p50_us": figure(|h| h.lateness_p50_ns * 1.0e-3),
        "late_p99_us": figure(|h| h.lateness_p99_ns * 1.0e-3),
        "late_max_us": figure(|h| h.lateness_max_ns * 1.0e-3),
        "body_p50_us": figure(|h| h.body_p50_ns * 1.0e-3),
        "body_p99_us": figure(|h| h.body_p99_ns * 1.0e-3),
        "missed": count(|h| h.missed_cycles),
        "missed_why": missed_why,
        "rejected": count(|h| h.rejected),
        "fenced": count(|h| h.fenced),
        "note": health.map_or("", |h| h.note.as_str()),
    })
}

fn scheduling(health: &Health) -> &'static str {
    if health.scheduling == Scheduling::Fifo.code() {
        "fifo"
    } else {
        "other"
    }
}

fn scheduling_of_run(input: &StatusInput<'_>) -> &'static str {
    // In lockstep no scheduling class matters.
    if input.world.is_some_and(|world| world.has(FLAG_LOCKSTEP)) {
        return "lockstep";
    }
    let physics = input.processes.iter().find(|(p, _)| *p == Process::Physics);
    // Physics is the loop that all others wait for.
    physics
        .and_then(|(_, health)| health.map(scheduling))
        .unwrap_or("other")
}

fn task(input: &StatusInput<'_>) -> Value {
    let decision = input.decision;
    let count = |of: fn(&Decision) -> u32| decision.map_or(0, of);
    let policy = decision.map_or("", |d| d.policy.as_str());
    let outcome = decision.and_then(|d| Outcome::from_code(d.outcome));
    let ticks = match (input.world, decision) {
        // In ticks, as ages are (ADR 0002): a paused cell does not age.
        (Some(world), Some(decision)) => world.header.tick.saturating_sub(decision.header.tick),
        _ => 0,
    };
    let sum = |of: fn(&ArmState) -> u64| -> u64 {
        input
            .world
            .map_or(0, |world| world.arms().iter().map(of).sum())
    };
    json!({
        // Before the first decision the policy of the run is shown.
        "policy": if policy.is_empty() { input.policy } else { policy },
        "outcome": outcome.map_or("idle", outcome_name),
        "phase": decision.map_or("", |d| d.phase.as_str()),
        "reason": decision.map_or("", |d| d.reason.as_str()),
        "wait": decision.map_or("", |d| d.wait.as_str()),
        "drops": count(|d| d.drops),
        "resyncs": count(|d| d.resyncs),
        "aborts": count(|d| d.aborts),
        "recoveries": count(|d| d.recoveries),
        "started": input.world.is_some_and(|world| world.panel.task_started == 1),
        "placed": placed(decision, input.objects),
        // A tick is a millisecond.
        "decision_age_ms": ticks,
        "limit_violations": sum(|arm| arm.limit_violations),
        "obstacle_contacts": sum(|arm| arm.obstacle_contacts),
        "self_contacts": sum(|arm| arm.self_contacts),
        "io": { "conveyor_running": decision.is_some_and(|d| d.io.conveyor_running == 1) },
    })
}

fn equipment(world: &WorldState, objects: &[String]) -> Value {
    let found = &world.equipment;
    let name = |number: u32| objects.get((number as usize).checked_sub(1)?);
    let refusal = SupplyRefusal::from_code(found.supply_refusal).unwrap_or_default();
    json!({
        "conveyor_speed_m_s": found.conveyor_speed,
        "bins_supplied": found.bins_supplied,
        "supply_refusals": found.supply_refusals,
        "supply_refusal": match refusal {
            SupplyRefusal::None => "",
            SupplyRefusal::NoneLeft => "none is left",
            SupplyRefusal::TooManyWaiting => "enough of them wait",
            SupplyRefusal::CoolDown => "the last one arrived a moment ago",
            SupplyRefusal::PlaceTaken => "its place is occupied",
        },
        "parts_dropped": found.parts_dropped,
        "parts_waiting": found.parts_waiting,
        "cleared": found.cleared,
        "sensors": found.sensors.map(name),
        "suction": world.arms().iter().map(|arm| suction(&arm.gripper)).collect::<Vec<_>>(),
    })
}

fn suction(gripper: &GripperState) -> Value {
    let limit = BreakLimit::from_code(gripper.break_limit).unwrap_or_default();
    let cause = BreakCause::from_code(gripper.break_cause).unwrap_or_default();
    let refusal = SuctionRefusal::from_code(gripper.refusal).unwrap_or_default();
    json!({
        "on": gripper.suction == 1,
        "force_n": gripper.suction_force,
        "torque_n_m": gripper.suction_torque,
        "peak_force_n": gripper.peak_force,
        "peak_torque_n_m": gripper.peak_torque,
        "breaks": gripper.breaks,
        "break_limit": match limit {
            BreakLimit::None => "",
            BreakLimit::Force => "force",
            BreakLimit::Torque => "torque",
        },
        "break_cause": match cause {
            BreakCause::None => "",
            BreakCause::Weight => "weight",
            BreakCause::Impulse => "impulse",
        },
        "refusals": gripper.refusals,
        "refusal": match refusal {
            SuctionRefusal::None => "",
            SuctionRefusal::NothingThere => "nothing was in front of the cup",
            SuctionRefusal::NotMovable => "the object there cannot be moved",
            SuctionRefusal::TooOblique => "the surface is too oblique",
        },
    })
}

fn outcome_name(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Idle => "idle",
        Outcome::Running => "running",
        Outcome::Done => "done",
        Outcome::Failed => "failed",
        Outcome::Paused => "paused",
    }
}

fn placed<'a>(decision: Option<&Decision>, objects: &'a [String]) -> Vec<&'a str> {
    let Some(decision) = decision else {
        return Vec::new();
    };
    // Bounded by the list itself: the count is from a message.
    let indices = decision.placed.iter().take(decision.placed_count as usize);
    indices
        .filter_map(|index| objects.get(*index as usize).map(String::as_str))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Text, Wire};

    #[test]
    fn a_silent_process_and_a_task_at_work_are_told() {
        let mut world = WorldState::zeroed();
        world.header.tick = 120;
        let mut decision = Decision::zeroed();
        decision.header.tick = 110;
        decision.outcome = Outcome::Running.code();
        decision.policy = Text::new("bt");
        (
            decision.placed_count,
            decision.placed[0],
            decision.placed[1],
        ) = (2, 1, 99);
        let mut health = Health::zeroed();
        (health.pid, health.lateness_p99_ns) = (7, 2500.0);
        let processes = [(Process::Physics, Some(&health)), (Process::Task, None)];
        let objects = ["red".to_owned(), "</script>".to_owned()];
        let message = status(&StatusInput {
            processes: &processes,
            missed: &["late".to_owned()],
            world: Some(&world),
            decision: Some(&decision),
            objects: &objects,
            breaks: &[],
            policy: "fsm",
        });
        assert_eq!(message["processes"][0]["late_p99_us"], 2.5);
        assert_eq!(message["processes"][0]["missed_why"], "late");
        assert_eq!(message["processes"][1]["state"], "silent");
        assert_eq!(message["processes"][1]["pid"], Value::Null);
        let task = &message["task"];
        assert_eq!(
            (&task["policy"], &task["outcome"]),
            (&json!("bt"), &json!("running"))
        );
        assert_eq!(task["placed"], json!(["</script>"]));
        assert_eq!(task["decision_age_ms"], 10);
        assert_eq!(message["rt"], "other");
    }
}
