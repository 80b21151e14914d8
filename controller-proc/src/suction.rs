//! Suction: on, off, or unchanged.

use ipc_types::{GripperGoal, GripperState};

use crate::checkpoint::{CheckpointError, Codec};

/// The command of a suction gripper; an arm without one has it off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SuctionController {
    fitted: bool,
    on: bool,
}

impl SuctionController {
    /// Off; `fitted` if the arm has suction at all.
    pub fn new(fitted: bool) -> Self {
        Self { fitted, on: false }
    }

    /// Starts from the measured state: a gripper that holds, or tries to, continues.
    pub fn start(&mut self, measured: &GripperState) {
        self.on = measured.attached == 1 || measured.suction == 1;
    }

    /// Closing switches it on, opening off; keeping keeps it.
    pub fn follow(&mut self, goal: GripperGoal) {
        match goal {
            GripperGoal::Keep => {}
            GripperGoal::Open => self.on = false,
            GripperGoal::Close => self.on = true,
        }
    }

    /// [`ipc_types::GripperCommand::suction`].
    pub fn code(&self) -> u32 {
        u32::from(self.fitted && self.on)
    }

    /// Writes or reads its state.
    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.bool("suction", &mut self.on)
    }
}
