//! What the operator's panel means to a task.

use ipc_types::decision::GoalKind;
use ipc_types::trace::TraceEvent;
use ipc_types::{GripperGoal, MAX_JOINTS, OperatorPanel, Pose};
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
    /// The task was reset and not resumed since: arms without a target of the operator
    /// return to their default pose.
    returns: bool,
    /// Tick of that reset.
    reset_tick: u64,
}

/// What changed on the panel since the last decision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "four buttons, each pressed or not"
)]
pub struct PanelChange {
    /// This is the first decision of a task, or of a scene.
    pub first: bool,
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
    pub fn update(&mut self, panel: &OperatorPanel, tick: u64) -> PanelChange {
        let paused = panel.task_paused == 1;
        let task_reset = self.seen && panel.task_reset != self.task_reset;
        let change = PanelChange {
            first: !self.seen,
            start: if self.seen {
                panel.task_start != self.task_start
            } else {
                panel.task_started == 1
            },
            reset: task_reset || self.seen && panel.scene_reset != self.scene_reset,
            pause: paused && !self.paused,
            resume: !paused && self.paused,
        };
        // What was asked before a reset is cleared by it, in a pause, too.
        if change.pause || change.reset {
            self.target_seq_at_pause = panel.target_seq;
            self.gripper_seq_at_pause = panel.gripper_seq;
        }
        if task_reset {
            self.reset_tick = tick;
        }
        self.returns = paused && (task_reset || self.returns && !change.reset);
        self.seen = true;
        self.task_start = panel.task_start;
        self.task_reset = panel.task_reset;
        self.scene_reset = panel.scene_reset;
        self.paused = paused;
        change
    }

    /// Whether `arm` returns to its default pose with an open gripper: the task was reset,
    /// and the operator has not led this arm since.
    pub(crate) fn returns(&self, panel: &OperatorPanel, arm: usize) -> bool {
        let asked = self.has_target(panel) || self.has_gripper(panel);
        self.returns && !(asked && panel.target_arm as usize == arm)
    }

    fn has_target(&self, panel: &OperatorPanel) -> bool {
        panel.target_seq > 0 && panel.target_seq != self.target_seq_at_pause
    }

    fn has_gripper(&self, panel: &OperatorPanel) -> bool {
        panel.gripper_seq != self.gripper_seq_at_pause
    }

    /// The way to the default pose at `tick`: the gripper opens, then the arm moves. `home`
    /// are the joints at the start of the run, for an arm without such a `pose`.
    pub(crate) fn to_default(
        &self,
        panel: &OperatorPanel,
        tick: u64,
        pose: Option<Pose>,
        home: [f64; MAX_JOINTS],
    ) -> ArmIntent {
        let opens = ArmIntent {
            gripper: GripperGoal::Open,
            ..ArmIntent::default()
        };
        if tick.saturating_sub(self.reset_tick) < OPENING_TICKS {
            return opens;
        }
        ArmIntent {
            kind: pose.map_or(GoalKind::Joints, |_| GoalKind::Pose),
            posture: Some(home),
            key: OPERATOR_KEYS | RETURN_KEYS | u64::from(panel.task_reset),
            target: pose.unwrap_or(Pose::IDENTITY),
            ..opens
        }
    }

    /// What the operator asks of `arm` in this pause.
    pub(crate) fn lead(&self, panel: &OperatorPanel, grip_force: f64) -> (usize, ArmIntent) {
        let (target, gripper) = (self.has_target(panel), self.has_gripper(panel));
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
/// Fingers are open after this, and what was in them does not follow the arm.
const OPENING_TICKS: u64 = 500;
/// Nor do those of a return to the default pose meet the operator's.
const RETURN_KEYS: u64 = 1 << 62;

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
