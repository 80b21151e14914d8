//! The setpoint of one joint, and its motion by a command.

use cell_model::JointSpec;
use cell_model::ramp::RampState;
use ipc_types::ArmCommand;

use crate::arm::violations;
use crate::engine::settings::TICK_S;

/// Whether two motions differ by less than a drive's limits cut off a command that is at a
/// limit except for rounding.
pub(super) fn same_motion(a: &RampState, b: &RampState) -> bool {
    const ROUNDING: f64 = 1.0e-5;
    (a.velocity - b.velocity).abs() <= ROUNDING
        && (a.position - b.position).abs() <= ROUNDING * TICK_S
}

/// The drive's own limits: the setpoint follows the command no faster than the
/// velocity limit and stays within the joint's range. A command within limits
/// passes unchanged.
pub(super) fn limited(before: RampState, command: RampState, spec: &JointSpec) -> RampState {
    let reach = spec.velocity * (1.0 + 1.0e-6) * TICK_S;
    let position = command
        .position
        .clamp(before.position - reach, before.position + reach);
    RampState {
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
    before: &RampState,
    command: &ArmCommand,
    joint: usize,
    spec: &JointSpec,
) -> (RampState, bool) {
    violations::advance(before, &commanded(command, joint), 1.0, spec)
}
