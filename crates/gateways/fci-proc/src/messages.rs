//! Between messages of the bus and the values of the interface.

use cell_model::ramp::RampState;
use fci::{Fingers, JOINTS, LateAnswer, Measured, Reflex, Setpoint};
use ipc_types::arm::{ClientState, DriveMode, StopAction, StopCause};
use ipc_types::topic::TopicId;
use ipc_types::{
    ArmCommand, ArmState, ArmStatus, GripperCommand, Header, Input, Pose, Text, WorldState,
};

/// The joints of the state of an arm.
pub(crate) fn measured(arm: &ArmState, is_new: bool) -> Measured {
    let of = |values: &[f64]| std::array::from_fn(|joint| values[joint]);
    Measured {
        positions: of(&arm.joint_positions),
        velocities: of(&arm.joint_velocities),
        torques: of(&arm.joint_efforts),
        setpoint: std::array::from_fn(|joint| RampState {
            position: arm.setpoint_positions[joint],
            velocity: arm.setpoint_velocities[joint],
            acceleration: arm.setpoint_accelerations[joint],
        }),
        is_held: is_new || arm.stop_action >= StopAction::Hold.code(),
    }
}

/// The fingers of the state of an arm.
pub(crate) fn fingers(arm: &ArmState) -> Fingers {
    Fingers {
        width: arm.gripper.width,
        velocity: arm.gripper.width_velocity,
        force: arm.gripper.grip_force,
    }
}

/// The messages that a command is computed from: the state, and the newest input of the client.
pub(crate) type Inputs<'a> = (&'a WorldState, Option<Input>);

pub(crate) fn caused_by<M: ipc_types::Wire>((state, client): Inputs<'_>) -> Header {
    let mut header = Header::caused_by::<M>(state.header.tick);
    header.push_input(Input {
        topic: TopicId::WorldState.code(),
        generation: state.header.generation,
        seq: state.header.seq,
        age_ticks: 0,
    });
    if let Some(client) = client {
        header.push_input(client);
    }
    header
}

/// Writes the command of a cycle.
pub(crate) fn command(
    inputs: Inputs<'_>,
    (arm, width, force): (u8, f64, f64),
    setpoint: &Setpoint,
    out: &mut ArmCommand,
) {
    out.header = caused_by::<ArmCommand>(inputs);
    out.arm = u32::from(arm);
    out.joint_count = u32::try_from(JOINTS).unwrap_or(u32::MAX);
    for (joint, of) in setpoint.joints.iter().enumerate() {
        out.joint_positions[joint] = of.position;
        out.joint_velocities[joint] = of.velocity;
        out.joint_accelerations[joint] = of.acceleration;
        out.joint_efforts[joint] = setpoint.efforts[joint];
    }
    out.drive_mode = if setpoint.by_torque {
        DriveMode::Effort.code()
    } else {
        DriveMode::Position.code()
    };
    out.gripper = GripperCommand {
        width,
        force,
        suction: 0,
        reserved: 0,
    };
}

/// Values of a status that its command does not have.
pub(crate) struct Progress {
    pub(crate) is_moving: bool,
    pub(crate) cycles: u64,
    pub(crate) missed_cycles: u64,
    pub(crate) client: ClientState,
}

/// Writes the status of a cycle.
pub(crate) fn status(
    inputs: Inputs<'_>,
    arm: &ArmState,
    command: &ArmCommand,
    progress: &Progress,
    out: &mut ArmStatus,
) {
    /// Clearance where no obstacle is regarded (m).
    const NO_OBSTACLE: f64 = 1.0e3;
    out.header = caused_by::<ArmStatus>(inputs);
    out.arm = command.arm;
    out.stop_action = StopAction::None.code();
    out.stop_cause = StopCause::None.code();
    out.goal_active = u32::from(progress.is_moving);
    out.setpoint = arm.tcp;
    out.target = Pose::IDENTITY;
    out.min_clearance = NO_OBSTACLE;
    out.gripper_error = arm.gripper.width - command.gripper.width;
    out.cycles = progress.cycles;
    out.missed_cycles = progress.missed_cycles;
    out.gripper = command.gripper;
    out.controller = Text::new("fci");
    out.client = progress.client;
}

/// A reflex in one line.
pub(crate) fn reflex(reflex: &Reflex) -> String {
    let broken = &reflex.broken;
    let of = broken
        .joint
        .map_or_else(String::new, |joint| format!("joint {}: ", joint + 1));
    let mut text = format!(
        "reflex {} in cycle {}: {of}{} {}, limit {}",
        broken.error.name(),
        reflex.cycle,
        short(broken.value),
        broken.unit,
        short(broken.limit),
    );
    if reflex.late.iter().flatten().next().is_some() {
        let answers: Vec<String> = runs(reflex)
            .into_iter()
            .map(|(answer, count)| match count {
                1 => answer,
                _ => format!("{answer} x {count}"),
            })
            .collect();
        text.push_str("; answers after ");
        text.push_str(&answers.join(", "));
    }
    text
}

/// Four digits of a number.
fn short(value: f64) -> String {
    if value != 0.0 && value.abs() < 1.0e-3 {
        return format!("{value:.3e}");
    }
    let digits = if value.abs() >= 100.0 { 0 } else { 4 };
    let text = format!("{value:.digits$}");
    match text.split_once('.') {
        Some((whole, part)) if part.chars().all(|digit| digit == '0') => whole.to_owned(),
        _ => text,
    }
}

/// How late the answers came, each with the number of those in a row, oldest first.
fn runs(reflex: &Reflex) -> Vec<(String, usize)> {
    let mut runs: Vec<(String, usize)> = Vec::new();
    for late in reflex.late.iter().flatten() {
        let answer = late_answer(late);
        match runs.last_mut() {
            Some((same, count)) if *same == answer => *count += 1,
            _ => runs.push((answer, 1)),
        }
    }
    runs
}

/// How late an answer came.
fn late_answer(late: &LateAnswer) -> String {
    late.after_cycles
        .map_or_else(|| "never".to_owned(), |cycles| format!("{cycles} ms"))
}
