//! Follows wanted joint positions within the limits of the robot.

use cell_model::Robot;
use ipc_types::TICK_S;
use rmp::{JointLimits, MotionState};

use crate::checkpoint::{CheckpointError, Codec};
use crate::controller::{Controller, Setpoint};
use crate::robot_state::{MAX_STATE_JOINTS, RobotState};

/// Gain of the follower (1/s): critically damped, 90 % of a step after 0.2 s.
const GAIN: f64 = 20.0;

/// Follows `setpoint.joints` by a joint-space PD law, `acceleration = k² (wanted - position) -
/// 2 k velocity`, within the robot's velocity, acceleration and jerk limits, so that physics
/// accepts its command for any input. Joints without a wanted position brake.
pub struct Follower {
    state: MotionState,
    limits: JointLimits,
    wanted: [f64; MAX_STATE_JOINTS],
    clipped: u64,
}

impl Follower {
    /// For the controlled joints of `robot`, at rest at its home.
    pub fn new(robot: &Robot) -> Self {
        Self {
            state: MotionState::at_rest(&robot.home()),
            limits: robot.limits(),
            wanted: [0.0; MAX_STATE_JOINTS],
            clipped: 0,
        }
    }

    /// Joints held back by a limit in the last cycle, bit per joint.
    pub fn clipped_joints(&self) -> u64 {
        self.clipped
    }

    /// Writes or reads the whole state.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.f64s(&mut self.state.positions)?;
        codec.f64s(&mut self.state.velocities)?;
        codec.f64s(&mut self.state.accelerations)?;
        codec.u64(&mut self.clipped)
    }
}

impl Controller for Follower {
    fn reset(&mut self, estimated: &RobotState) -> bool {
        let n = self.state.positions.len();
        let state = &mut self.state;
        state
            .positions
            .copy_from_slice(estimated.positions.first(n));
        state
            .velocities
            .copy_from_slice(estimated.velocities.first(n));
        state
            .accelerations
            .copy_from_slice(estimated.accelerations.first(n));
        true
    }

    fn forward(&mut self, _estimated: &RobotState, setpoint: &Setpoint) -> Option<RobotState> {
        let n = self.state.positions.len();
        let joints = self.state.positions.iter().zip(&self.state.velocities);
        for (joint, (slot, (position, velocity))) in self.wanted.iter_mut().zip(joints).enumerate()
        {
            let goal = setpoint.joints.positions.get(joint);
            // A number that is not finite brakes its joint: controllers of users are not
            // validated.
            let off = goal
                .filter(|goal| goal.is_finite())
                .map_or(0.0, |goal| goal - position);
            *slot = GAIN * GAIN * off - 2.0 * GAIN * velocity;
        }
        let wanted = self.wanted.get(..n)?;
        let clips = rmp::follow(&mut self.state, &self.limits, wanted, TICK_S).ok()?;
        self.clipped =
            clips.position | clips.velocity | clips.acceleration | clips.jerk | clips.conflict;
        let mut command = RobotState::EMPTY;
        command.positions.set_from(0, &self.state.positions);
        command.velocities.set_from(0, &self.state.velocities);
        command.accelerations.set_from(0, &self.state.accelerations);
        Some(command)
    }
}
