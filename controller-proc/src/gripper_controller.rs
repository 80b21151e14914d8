//! The fingers of a parallel gripper: open, closed, or as they are.

use ipc_types::{GripperGoal, GripperState};

use crate::checkpoint::{CheckpointError, Codec};
use crate::controller::{Controller, Setpoint};
use crate::robot_state::RobotState;

/// Grip force from which a hand holds something when a controller starts (N).
// A wrong "holding" closes an empty hand; a wrong "not holding" drops an object, so the limit
// is far below any grip force.
const HOLDING_FORCE_N: f64 = 1.0;

/// Commands the fingers of a parallel gripper to a width.
pub struct GripperController {
    first_joint: usize,
    fingers: usize,
    open_width: f64,
    width: f64,
}

impl GripperController {
    /// Fingers are the `fingers` joints from `first_joint` on, `open_width` apart (m) when
    /// open, as they are now.
    pub fn new(first_joint: usize, fingers: usize, open_width: f64) -> Self {
        Self {
            first_joint,
            fingers,
            open_width,
            width: open_width,
        }
    }

    /// Starts from the measured state. A hand that holds something keeps its grip: an open
    /// width would drop the object.
    pub fn begin(&mut self, measured: &GripperState) {
        let holding = measured.grip_force > HOLDING_FORCE_N;
        self.width = if holding { 0.0 } else { measured.width };
    }

    /// Takes the width of a goal; keeping keeps it. An open hand has `open_width` (m), or 0 for
    /// its largest.
    pub fn follow(&mut self, goal: GripperGoal, open_width: f64) {
        match goal {
            GripperGoal::Keep => {}
            GripperGoal::Open if open_width > 0.0 => self.width = open_width.min(self.open_width),
            GripperGoal::Open => self.width = self.open_width,
            GripperGoal::Close => self.width = 0.0,
        }
    }

    /// Writes or reads its state.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.f64(&mut self.width)
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
