//! The motion of an arm in free space: a sine at each joint, as commands of a controller.

use cell_model::{ArmSpec, Dynamics, JointSpec};
use ipc_types::{ArmCommand, GripperCommand, Header, Wire};
use nalgebra::Vector3;
use physics_proc::engine::settings::{GRAVITY, TICK_S};

/// Centre of the motion (rad): the Panda stays within its limits and touches nothing.
pub(super) const CENTRE: [f64; 7] = [0.0, -0.6, 0.0, -2.2, 0.0, 2.0, 0.785];
/// Amplitude (rad) and frequency (Hz).
pub(super) const AMPLITUDE: f64 = 0.3;
pub(super) const FREQUENCY_HZ: f64 = 0.5;
/// Time in which the motion grows to its full amplitude (s).
// A sudden start would break acceleration limits, and physics would brake the arm.
const START_S: f64 = 2.0;
/// Ticks of the start.
pub(super) const START_TICKS: usize = 2_000;

/// Setpoints of the joints.
pub(super) struct Sine {
    arm: ArmSpec,
    dynamics: Dynamics,
    ticks: u64,
}

impl Sine {
    /// At rest at the centre.
    pub(super) fn new(arm: &ArmSpec) -> Self {
        Self {
            dynamics: Dynamics::new(&arm.robot),
            arm: arm.clone(),
            ticks: 0,
        }
    }

    /// The command of the next tick, with its feed-forward.
    pub(super) fn next(&mut self) -> ArmCommand {
        let mut command = ArmCommand::zeroed();
        command.header = Header::caused_by::<ArmCommand>(self.ticks);
        self.ticks += 1;
        // Numbers grow by one, or physics would take the command for an old one.
        (command.header.generation, command.header.seq) = (1, self.ticks);
        let [position, velocity, acceleration] = moved(self.ticks as f64 * TICK_S);
        let joints = CENTRE.len();
        command.joint_count = u32::try_from(joints).unwrap_or_default();
        let positions = CENTRE.map(|centre| centre + position);
        let (velocities, accelerations) = (CENTRE.map(|_| velocity), CENTRE.map(|_| acceleration));
        command.joint_positions[..joints].copy_from_slice(&positions);
        command.joint_velocities[..joints].copy_from_slice(&velocities);
        command.joint_accelerations[..joints].copy_from_slice(&accelerations);
        // Feed-forward as of a controller: without it the drives would work against gravity.
        let gravity = Vector3::from(GRAVITY);
        let states = (&positions, &velocities, &accelerations);
        let efforts = self
            .dynamics
            .inverse_dynamics(states.0, states.1, states.2, &gravity);
        command.joint_efforts[..joints].copy_from_slice(efforts);
        command.gripper = GripperCommand {
            width: self
                .arm
                .robot
                .gripper
                .as_ref()
                .map_or(0.0, |hand| hand.max_width),
            ..GripperCommand::zeroed()
        };
        command
    }

    /// The same for `MuJoCo`'s position servos, which have neither a target of velocity nor a
    /// feed-forward: both shift the target, as in our drives. By joint of the chain, from its
    /// start position (rad or m).
    pub(super) fn controls(&self, command: &ArmCommand) -> Vec<f64> {
        let robot = &self.arm.robot;
        let mut controls = vec![0.0; robot.joints.len()];
        for (place, &joint) in robot.arm_joints.iter().enumerate() {
            let JointSpec {
                stiffness, damping, ..
            } = robot.joints[joint];
            let shift = damping * command.joint_velocities[place] + command.joint_efforts[place];
            let position = command.joint_positions[place] - self.arm.home[place];
            controls[joint] = position + shift / stiffness;
        }
        controls
    }
}

/// Position (rad), velocity (rad/s) and acceleration (rad/s²) at a time (s).
fn moved(time_s: f64) -> [f64; 3] {
    let rate = std::f64::consts::TAU * FREQUENCY_HZ;
    let (sin, cos) = (rate * time_s).sin_cos();
    let wave = [sin, rate * cos, -rate * rate * sin].map(|value| AMPLITUDE * value);
    let s = (time_s / START_S).min(1.0);
    // Of seventh degree: velocity, acceleration and jerk are 0 at both ends.
    let share = s.powi(4) * (35.0 - 84.0 * s + 70.0 * s.powi(2) - 20.0 * s.powi(3));
    let first = 140.0 * (s * (1.0 - s)).powi(3) / START_S;
    let second = 420.0 * (s * (1.0 - s)).powi(2) * (1.0 - 2.0 * s) / START_S.powi(2);
    [
        share * wave[0],
        share * wave[1] + first * wave[0],
        share * wave[2] + 2.0 * first * wave[1] + second * wave[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn velocity_and_acceleration_are_those_of_the_position() {
        let step = 1.0e-5;
        for at in [0.3, 1.1, 1.9, 2.5, 3.7] {
            let [before, now, after] = [at - step, at, at + step].map(moved);
            let slope = |of: usize| (after[of] - before[of]) / (2.0 * step);
            assert!((slope(0) - now[1]).abs() < 1.0e-7, "{at}");
            assert!((slope(1) - now[2]).abs() < 1.0e-7, "{at}");
        }
    }
}
