//! The texts of a frame of `top`, from the bus of the cell.

use ipc_types::equipment::BreakLimit;
use ipc_types::world::FLAG_PAUSED;
use ipc_types::{ArmState, GripperState};

use super::View;
use super::equipment::Names;
use crate::client::process_table::ProcessStatus;
use crate::client::status::{breakpoint, pace, processes, waits_for, word};

/// All texts of a frame.
#[derive(Debug, Default)]
pub(super) struct Screen {
    /// Demo, cell and time.
    pub(super) title: String,
    /// How the task is doing.
    pub(super) task: String,
    /// The nodes or states at work, by picture of the policy.
    pub(super) active: Vec<String>,
    pub(super) processes: Vec<ProcessStatus>,
    /// Lines of all arms.
    pub(super) arms: Vec<String>,
    /// A line for each device; nothing in a cell without equipment.
    pub(super) equipment: Vec<String>,
    /// What the task said: simulated seconds and text, the oldest first.
    pub(super) log: Vec<(f64, String)>,
}

impl Screen {
    /// What `view` has seen.
    pub(super) fn of(view: &View) -> Self {
        let state = view.picture.state();
        let arms = state.map_or(&[][..], ipc_types::WorldState::arms);
        let arms = arms.iter().enumerate();
        let equipment = state.map(|state| view.names.lines(&state.equipment));
        Self {
            title: title(view),
            task: task(view),
            active: view.trace.active(),
            processes: processes(&view.picture),
            arms: arms
                .flat_map(|(i, arm)| arm_lines(i, arm, &view.names))
                .collect(),
            equipment: equipment.unwrap_or_default(),
            log: view.trace.log.iter().cloned().collect(),
        }
    }
}

fn title(view: &View) -> String {
    let spec = &view.session.spec;
    let (state, decision) = (view.picture.state(), view.picture.decision());
    let time = state.map_or_else(
        || "no state".to_owned(),
        |s| format!("{:.2} s", s.header.sim_time_ns as f64 * 1e-9),
    );
    let pace = pace(view.picture.real_time_factor());
    let pause = match breakpoint(state, decision) {
        Some(name) => format!("  PAUSED by breakpoint {name}"),
        None if state.is_some_and(|s| s.has(FLAG_PAUSED)) => "  PAUSED".to_owned(),
        None => String::new(),
    };
    format!(
        "{}  cell `{}`  seed {}  {time}{pace}{pause}  (q quits)",
        spec.demo, spec.cell, spec.seed
    )
}

fn task(view: &View) -> String {
    let decision = view.picture.decision();
    decision.map_or_else(
        || "no decision".to_owned(),
        |d| {
            let outcome = word(d.outcome);
            let waits = waits_for(&outcome);
            let wait = match d.wait.as_str() {
                "" => String::new(),
                wait => format!("  waiting: {wait}"),
            };
            format!(
                "{}: {outcome}{waits} {}  phase {}  placed {}  drops {}  resyncs {}  aborts {}{wait}",
                d.policy, d.reason, d.phase, d.placed_count, d.drops, d.resyncs, d.aborts
            )
        },
    )
}

fn arm_lines(index: usize, arm: &ArmState, names: &Names) -> [String; 4] {
    let count = arm.joint_count as usize;
    let gripper = &arm.gripper;
    let text = if names.has_suction(index) {
        suction_text(gripper)
    } else {
        fingers_text(gripper)
    };
    let gripper = if names.has_no_gripper(index) {
        "no gripper".to_owned()
    } else {
        let held = names.object(gripper.held_object, "nothing");
        format!("{text}, holds {held}")
    };
    let list = |values: &[f64]| {
        let values = values.iter().take(count);
        let texts: Vec<_> = values.map(|v| format!("{v:>8.3}")).collect();
        texts.concat()
    };
    let [x, y, z] = arm.tcp.position;
    [
        format!(
            "{:<14}{}",
            format!("{index} joints {}", names.units(index)),
            list(&arm.joint_positions)
        ),
        format!("  efforts     {}", list(&arm.joint_efforts)),
        format!(
            "  tcp {x:.3} {y:.3} {z:.3} m, limit violations {}",
            arm.limit_violations
        ),
        format!("  {gripper}"),
    ]
}

fn suction_text(gripper: &GripperState) -> String {
    let limit = match BreakLimit::from_code(gripper.break_limit) {
        Some(BreakLimit::Force) => " (force limit)",
        Some(BreakLimit::Torque) => " (torque limit)",
        _ => "",
    };
    format!(
        "suction {}, {:.1} N {:.2} Nm, load {:.0} %, broke {} times{limit}, refused {}",
        if gripper.suction == 1 { "on" } else { "off" },
        gripper.suction_force,
        gripper.suction_torque,
        gripper.load * 100.0,
        gripper.breaks,
        gripper.refusals
    )
}

fn fingers_text(gripper: &GripperState) -> String {
    let beam = if gripper.beam_object == 0 {
        "free"
    } else {
        "interrupted"
    };
    format!(
        "gripper {:.1} mm {:.1} N, beam {beam}",
        gripper.width * 1e3,
        gripper.grip_force
    )
}
