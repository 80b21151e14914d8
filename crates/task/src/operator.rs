//! What the operator's panel means to a task.

use ipc_types::decision::GoalKind;
use ipc_types::trace::TraceEvent;
use ipc_types::{GripperGoal, OperatorPanel};
use serde::{Deserialize, Serialize};

use crate::output::{ArmIntent, Output};

/// The panel as it was at the last decision: requests are counters, so a
/// request is a change, whatever was missed in between.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PanelState {
    seen: bool,
    task_start: u32,
    task_reset: u32,
    scene_reset: u32,
    paused: bool,
    /// Counters when the pause began: only what is asked after it counts.
    target_seq_at_pause: u32,
    gripper_seq_at_pause: u32,
}

/// What changed on the panel since the last decision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "four buttons, each pressed or not"
)]
pub struct PanelChange {
    /// The task was asked to start; at the first decision, that it was asked
    /// before and not put back since.
    pub start: bool,
    /// The task was asked to restart, or the scene was put back.
    pub reset: bool,
    /// The task is paused now and was not.
    pub pause: bool,
    /// The task was paused and is not any more.
    pub resume: bool,
}

impl PanelState {
    /// Whether the task is paused.
    pub fn paused(&self) -> bool {
        self.paused
    }

    /// Takes the panel of a new decision. The first one only sets the counters,
    /// but for the start: what was asked of an earlier task is not asked again.
    pub fn update(&mut self, panel: &OperatorPanel) -> PanelChange {
        let paused = panel.task_paused == 1;
        let change = PanelChange {
            start: if self.seen {
                panel.task_start != self.task_start
            } else {
                panel.task_started == 1
            },
            reset: self.seen
                && (panel.task_reset != self.task_reset || panel.scene_reset != self.scene_reset),
            pause: paused && !self.paused,
            resume: !paused && self.paused,
        };
        if change.pause {
            self.target_seq_at_pause = panel.target_seq;
            self.gripper_seq_at_pause = panel.gripper_seq;
        }
        self.seen = true;
        self.task_start = panel.task_start;
        self.task_reset = panel.task_reset;
        self.scene_reset = panel.scene_reset;
        self.paused = paused;
        change
    }

    /// What the operator asks of `arm` in this pause.
    pub(crate) fn lead(&self, panel: &OperatorPanel, grip_force: f64) -> (usize, ArmIntent) {
        let target = panel.target_seq > 0 && panel.target_seq != self.target_seq_at_pause;
        let gripper = panel.gripper_seq != self.gripper_seq_at_pause;
        let intent = ArmIntent {
            gripper: if gripper {
                requested_gripper(panel)
            } else {
                GripperGoal::Keep
            },
            grip_force,
            ..if target {
                operator_target(panel)
            } else {
                ArmIntent::default()
            }
        };
        (panel.target_arm as usize, intent)
    }
}

/// The operator's target, of the TCP or of the joints, as a goal.
pub fn operator_target(panel: &OperatorPanel) -> ArmIntent {
    let joints = (panel.target_is_joints == 1).then_some(panel.target_joints);
    ArmIntent {
        kind: joints.map_or(GoalKind::Pose, |_| GoalKind::Joints),
        posture: joints,
        key: OPERATOR_KEYS | u64::from(panel.target_seq),
        target: panel.target,
        ..ArmIntent::default()
    }
}

/// The newest gripper request of the operator.
pub fn requested_gripper(panel: &OperatorPanel) -> GripperGoal {
    GripperGoal::from_code(panel.gripper).unwrap_or_default()
}

/// Keys of the operator's goals never meet those of a policy.
const OPERATOR_KEYS: u64 = 1 << 63;

/// Says what changed, for the log.
pub(crate) fn log_change(change: PanelChange, out: &mut Output) {
    if change.reset {
        out.lifecycle(TraceEvent::None, format_args!("[task] reset"));
    }
    if change.pause {
        out.lifecycle(
            TraceEvent::None,
            format_args!("[task] paused: the operator leads"),
        );
    }
    if change.resume {
        out.lifecycle(TraceEvent::None, format_args!("[task] resumed"));
    }
}
