//! The checkpoint of the motion: all that it remembers from cycle to cycle.

use super::{Mode, RmpFlowController};
use crate::checkpoint::{CheckpointError, Codec, damaged};
use crate::robot_state::MAX_STATE_JOINTS;

impl RmpFlowController {
    /// Writes or reads all that is remembered from cycle to cycle.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.f64s(&mut self.state.positions)?;
        codec.f64s(&mut self.state.velocities)?;
        codec.f64s(&mut self.state.accelerations)?;
        codec.f64s(&mut self.posture)?;
        let mut mode = self.mode as u32;
        codec.u32(&mut mode)?;
        self.mode = match mode {
            0 => Mode::Follow,
            1 => Mode::Brake,
            2 => Mode::Stay,
            found => return Err(damaged("mode", u64::from(found))),
        };
        codec.pose(&mut self.tool_pose)?;
        codec.f64(&mut self.min_clearance)?;
        codec.u64(&mut self.clipped_joints)?;
        self.surroundings
            .checkpoint(codec, self.flow.obstacles_mut())?;
        self.held.checkpoint(codec, &mut self.flow, self.tool)?;
        self.planning.checkpoint(codec)?;
        // After the path was read: its gains follow from it.
        if codec.reads() {
            self.set_gains().map_err(|_refused| damaged("gains", 0))?;
        }
        self.record_flow(codec)
    }

    /// State of the policies themselves: posture, target, and the bounds that were active,
    /// from which the next resolve starts.
    fn record_flow(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        let mut posture = [0.0; MAX_STATE_JOINTS];
        let joints = self.flow.joint_count().min(MAX_STATE_JOINTS);
        posture[..joints].copy_from_slice(&self.flow.posture()[..joints]);
        codec.f64s(&mut posture[..joints])?;
        let mut target = self.target;
        codec.option("target", &mut target.position, |codec, position| {
            codec.f64s(position.iter_mut())
        })?;
        codec.option("target", &mut target.orientation, Codec::rotation)?;
        let (mut lower, mut upper) = self.flow.active_bounds();
        codec.u64(&mut lower)?;
        codec.u64(&mut upper)?;
        if codec.reads() {
            self.flow.set_active_bounds(lower, upper);
            let told = self.flow.set_posture(&posture[..joints]);
            told.and_then(|()| self.lead(target))
                .map_err(|_not_finite| damaged("posture or target", 0))?;
        }
        Ok(())
    }
}
