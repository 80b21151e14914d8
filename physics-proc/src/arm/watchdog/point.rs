//! The setpoint of one joint, and its motion by a command.

use cell_model::JointSpec;
use cell_model::ramp::RampState;
use ipc_types::ArmCommand;
use serde::{Deserialize, Serialize};

use crate::arm::violations;
use crate::engine::settings::TICK_S;

/// One joint, as plain numbers for the snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Point {
    pub(super) position: f64,
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
}

/// Whether two points differ by less than a drive's limits cut off a command that is at a
/// limit except for rounding.
pub(super) fn same_motion(a: &Point, b: &Point) -> bool {
    const ROUNDING: f64 = 1.0e-5;
    (a.velocity - b.velocity).abs() <= ROUNDING
        && (a.position - b.position).abs() <= ROUNDING * TICK_S
}

/// The drive's own limits: the setpoint follows the command no faster than the
/// velocity limit and stays within the joint's range. A command within limits
/// passes unchanged.
pub(super) fn limited(before: Point, command: RampState, spec: &JointSpec) -> Point {
    let reach = spec.velocity * (1.0 + 1.0e-6) * TICK_S;
    let position = command
        .position
        .clamp(before.position - reach, before.position + reach);
    Point {
        position: position.clamp(spec.lower, spec.upper),
        velocity: command.velocity.clamp(-spec.velocity, spec.velocity),
        acceleration: command
            .acceleration
            .clamp(-spec.acceleration, spec.acceleration),
    }
}

/// The commanded motion of a joint.
pub(super) fn commanded(command: &ArmCommand, joint: usize) -> RampState {
    RampState {
        position: command.joint_positions[joint],
        velocity: command.joint_velocities[joint],
        acceleration: command.joint_accelerations[joint],
    }
}

/// The motion of a joint by a command in one tick, and whether it breaks a limit.
pub(super) fn advance_one(
    before: &Point,
    command: &ArmCommand,
    joint: usize,
    spec: &JointSpec,
) -> (RampState, bool) {
    violations::advance(&ramp_state(*before), &commanded(command, joint), 1.0, spec)
}

/// The state of a joint as a point.
pub(super) fn point(state: RampState) -> Point {
    Point {
        position: state.position,
        velocity: state.velocity,
        acceleration: state.acceleration,
    }
}

/// A point as the state of a joint.
pub(super) fn ramp_state(point: Point) -> RampState {
    RampState {
        position: point.position,
        velocity: point.velocity,
        acceleration: point.acceleration,
    }
}
