//! A gripper that moves to one width.

use crate::checkpoint::{CheckpointError, Codec};
use crate::controller::{Controller, Setpoint};
use crate::robot_state::RobotState;

/// Commands the fingers of a parallel gripper to a fixed width.
pub struct GripperController {
    first_joint: usize,
    fingers: usize,
    width: f64,
}

impl GripperController {
    /// Fingers are the `fingers` joints from `first_joint` on; `width` is their
    /// distance (m).
    pub fn new(first_joint: usize, fingers: usize, width: f64) -> Self {
        Self {
            first_joint,
            fingers,
            width,
        }
    }

    /// Writes or reads its state.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.f64(&mut self.width)
    }

    /// Another width (m).
    pub fn set_width(&mut self, width: f64) {
        self.width = width;
    }
}

impl Controller for GripperController {
    fn reset(&mut self, _estimated: &RobotState) -> bool {
        true
    }

    fn forward(&mut self, _estimated: &RobotState, _setpoint: &Setpoint) -> Option<RobotState> {
        let mut state = RobotState::EMPTY;
        for finger in 0..self.fingers {
            let share = self.width / self.fingers as f64;
            state.positions.set(self.first_joint + finger, share);
        }
        Some(state)
    }
}
