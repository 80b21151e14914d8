//! The operator's panel: levels and counters of people's requests (ADR 0001).

use ipc_types::{MAX_BREAKS, MAX_JOINTS, OperatorPanel, Text};
use serde::{Deserialize, Serialize};

use crate::operator::contact_stop::ContactStop;

/// [`OperatorPanel`] as part of a snapshot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Panel {
    pub(super) task_start: u32,
    pub(super) task_started: bool,
    pub(super) task_reset: u32,
    pub(super) task_paused: bool,
    pub(super) target_arm: u32,
    pub(super) target_seq: u32,
    pub(super) target_position: [f64; 3],
    pub(super) target_orientation_wxyz: [f64; 4],
    pub(super) gripper_seq: u32,
    pub(super) gripper: u32,
    pub(super) drop_parts: u32,
    pub(super) add_bin: u32,
    pub(super) scene_reset: u32,
    /// Replaces the pose if it is set.
    pub(super) target_joints: Option<[f64; MAX_JOINTS]>,
    /// Breakpoints of the task.
    pub(super) breaks: Vec<String>,
    pub(super) contact: ContactStop,
}

impl Panel {
    /// Nothing was asked for yet.
    pub(super) const NEW: Self = Self {
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
        target_joints: None,
        breaks: Vec::new(),
        contact: ContactStop::NEW,
    };

    /// As it is published.
    pub(super) fn to_wire(&self) -> OperatorPanel {
        let mut breaks = [Text::EMPTY; MAX_BREAKS];
        for (text, name) in breaks.iter_mut().zip(&self.breaks) {
            *text = Text::new(name);
        }
        OperatorPanel {
            task_start: self.task_start,
            task_started: u32::from(self.task_started),
            // The plant writes these two.
            pause_cause: 0,
            speed: 0.0,
            contact_stops: self.contact.stops,
            contact_with: self.contact.with,
            contact_limit: self.contact.limit_n,
            contact_force: self.contact.force_n,
            task_reset: self.task_reset,
            task_paused: u32::from(self.task_paused),
            target_arm: self.target_arm,
            target_seq: self.target_seq,
            gripper_seq: self.gripper_seq,
            gripper: self.gripper,
            drop_parts: self.drop_parts,
            add_bin: self.add_bin,
            scene_reset: self.scene_reset,
            target_is_joints: u32::from(self.target_joints.is_some()),
            break_count: u32::try_from(self.breaks.len()).unwrap_or(0),
            target_joints: self.target_joints.unwrap_or_default(),
            breaks,
            target: ipc_types::Pose {
                position: self.target_position,
                orientation_wxyz: self.target_orientation_wxyz,
            },
        }
    }
}
