//! Between messages of the bus and the values of the interface.

use cell_model::ramp::RampState;
use fci::{Fingers, JOINTS, Measured, Reflex, Setpoint};
use ipc_types::arm::{DriveMode, StopAction, StopCause};
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

fn caused_by<M: ipc_types::Wire>(state: &WorldState) -> Header {
    let mut header = Header::caused_by::<M>(state.header.tick);
    header.push_input(Input {
        topic: TopicId::WorldState.code(),
        generation: state.header.generation,
        seq: state.header.seq,
        age_ticks: 0,
    });
    header
}

/// Writes the command of a cycle.
pub(crate) fn command(
    state: &WorldState,
    (arm, width, force): (u8, f64, f64),
    setpoint: &Setpoint,
    out: &mut ArmCommand,
) {
    out.header = caused_by::<ArmCommand>(state);
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
}

/// Writes the status of a cycle.
pub(crate) fn status(
    state: &WorldState,
    arm: &ArmState,
    command: &ArmCommand,
    progress: &Progress,
    out: &mut ArmStatus,
) {
    /// Clearance where no obstacle is regarded (m).
    const NO_OBSTACLE: f64 = 1.0e3;
    out.header = caused_by::<ArmStatus>(state);
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
}

/// A reflex in one line.
pub(crate) fn reflex(reflex: &Reflex) -> String {
    let broken = &reflex.broken;
    let of = broken
        .joint
        .map_or_else(String::new, |joint| format!("joint {}: ", joint + 1));
    format!(
        "reflex {} in cycle {}: {of}{:.4} {}, limit {:.4}",
        broken.error.name(),
        reflex.cycle,
        broken.value,
        broken.unit,
        broken.limit,
    )
}
