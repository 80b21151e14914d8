//! The operator's panel: levels and counters of what people asked for.

use ipc_types::OperatorPanel;
use serde::{Deserialize, Serialize};

/// [`OperatorPanel`] as part of a snapshot.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Panel {
    pub(crate) task_start: u32,
    pub(crate) task_started: bool,
    pub(crate) task_reset: u32,
    pub(crate) task_paused: bool,
    pub(crate) target_arm: u32,
    pub(crate) target_seq: u32,
    pub(crate) target_position: [f64; 3],
    pub(crate) target_orientation_wxyz: [f64; 4],
    pub(crate) gripper_seq: u32,
    pub(crate) gripper: u32,
    pub(crate) drop_parts: u32,
    pub(crate) add_bin: u32,
    pub(crate) scene_reset: u32,
}

impl Panel {
    /// Nothing was asked for yet.
    pub(crate) const NEW: Self = Self {
        task_start: 0,
        task_started: false,
        task_reset: 0,
        task_paused: false,
        target_arm: 0,
        target_seq: 0,
        target_position: [0.0; 3],
        target_orientation_wxyz: [1.0, 0.0, 0.0, 0.0],
        gripper_seq: 0,
        gripper: 0,
        drop_parts: 0,
        add_bin: 0,
        scene_reset: 0,
    };

    /// As it is published.
    pub(crate) fn to_wire(self) -> OperatorPanel {
        OperatorPanel {
            task_start: self.task_start,
            task_started: u32::from(self.task_started),
            // The plant knows it.
            pause_cause: 0,
            task_reset: self.task_reset,
            task_paused: u32::from(self.task_paused),
            target_arm: self.target_arm,
            target_seq: self.target_seq,
            gripper_seq: self.gripper_seq,
            gripper: self.gripper,
            drop_parts: self.drop_parts,
            add_bin: self.add_bin,
            scene_reset: self.scene_reset,
            target: ipc_types::Pose {
                position: self.target_position,
                orientation_wxyz: self.target_orientation_wxyz,
            },
        }
    }
}
