//! The operator's panel as a task interprets it.

use ipc_types::decision::GoalKind;
use ipc_types::trace::TraceEvent;
use ipc_types::{GripperGoal, MAX_JOINTS, OperatorPanel, Pose};
use serde::{Deserialize, Serialize};

use crate::output::{ArmIntent, Output};

/// The panel as it was at the last decision. Requests are counters: a request is a change
/// of a counter, however many states were missed in between (ADR 0001).
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PanelState {
    seen: bool,
    task_start: u32,
    task_reset: u32,
    scene_reset: u32,
    paused: bool,
    /// Counters at the start of the pause: only requests after it count.
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
    /// The task was asked to start. At the first decision: it was asked to start before,
    /// and was not reset since.
    pub start: bool,
    /// The task was asked to restart, or the scene was reset.
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

    /// Compares the panel of a new decision with that of the last one. The first call only
    /// sets the counters, except for the start: requests to an earlier task are not repeated.
    pub fn update(&mut self, panel: &OperatorPanel, tick: u64) -> PanelChange {
        let paused = panel.task_paused == 1;
        // `seen` guards the first decision: the counters of the panel are older than this task,
        // and each difference from zero would count as a request.
        let task_reset = self.seen && panel.task_reset != self.task_reset;
        let change = PanelChange {
            first: !self.seen,
            // A level, not a counter, at the first decision: a task that is started again in a
            // running cell has to know that the operator started the job.
            start: if self.seen {
                panel.task_start != self.task_start
            } else {
                panel.task_started == 1
            },
            reset: task_reset || self.seen && panel.scene_reset != self.scene_reset,
            pause: paused && !self.paused,
            resume: !paused && self.paused,
        };
        // Requests from before a pause do not move the arm in it. One that arrives between the last
        // decision and the first of the pause counts as one of the pause: on a busy machine both are
        // in one state. A reset cancels earlier requests, in a pause, too.
        if change.first || !paused || change.reset {
            self.target_seq_at_pause = panel.target_seq;
            self.gripper_seq_at_pause = panel.gripper_seq;
        }
        if task_reset {
            self.reset_tick = tick;
        }
        // Only in a pause: a running policy moves the arm itself, and a return to the default
        // pose would compete with its goals.
        self.returns = paused && (task_reset || self.returns && !change.reset);
        self.seen = true;
        self.task_start = panel.task_start;
        self.task_reset = panel.task_reset;
        self.scene_reset = panel.scene_reset;
        self.paused = paused;
        change
    }

    /// Whether `arm` returns to its default pose with an open gripper: the task was reset,
    /// and the operator has not moved this arm since.
    pub(crate) fn returns(&self, panel: &OperatorPanel, arm: usize) -> bool {
        let asked = self.has_target(panel) || self.has_gripper(panel);
        self.returns && !(asked && panel.target_arm as usize == arm)
    }

    fn has_target(&self, panel: &OperatorPanel) -> bool {
        // A request from before the pause must not move the arm as soon as the task pauses.
        panel.target_seq > 0 && panel.target_seq != self.target_seq_at_pause
    }

    fn has_gripper(&self, panel: &OperatorPanel) -> bool {
        panel.gripper_seq != self.gripper_seq_at_pause
    }

    /// The intent that returns the arm to its default pose at `tick`: the gripper opens, then
    /// the arm moves. `home` are the joints at the start of the run (rad or m), for an arm
    /// without such a `pose`.
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
        // An arm that moves with closing or half-open fingers takes the object with it.
        if tick.saturating_sub(self.reset_tick) < OPENING_TICKS {
            return opens;
        }
        ArmIntent {
            kind: pose.map_or(GoalKind::Joints, |_| GoalKind::Pose),
            posture: Some(home),
            // The counter of resets is in the key, so a second reset is a new goal, which a
            // controller that has reached the first one follows again.
            key: OPERATOR_KEYS | RETURN_KEYS | u64::from(panel.task_reset),
            target: pose.unwrap_or(Pose::IDENTITY),
            ..opens
        }
    }

    /// What the operator requests of `arm` in this pause.
    pub(crate) fn lead(&self, panel: &OperatorPanel, grip_force: f64) -> (usize, ArmIntent) {
        let (target, gripper) = (self.has_target(panel), self.has_gripper(panel));
        let intent = ArmIntent {
            // No request keeps the gripper: a pause while an object is held must not drop it.
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
        // The number of the request is in the key: each request is a new goal.
        key: OPERATOR_KEYS | u64::from(panel.target_seq),
        target: panel.target,
        ..ArmIntent::default()
    }
}

/// The newest gripper request of the operator.
pub fn requested_gripper(panel: &OperatorPanel) -> GripperGoal {
    // A code of another version is treated as no request.
    GripperGoal::from_code(panel.gripper).unwrap_or_default()
}

/// Bit that keeps keys of the operator's goals apart from those of a policy.
// A policy and the operator number their goals independently. With equal keys the goal of the
// one would count as a moved goal of the other, under the same number.
const OPERATOR_KEYS: u64 = 1 << 63;
/// After so many ticks the fingers are open, and an object between them stays behind.
const OPENING_TICKS: u64 = 500;
/// Bit that keeps a return to the default pose apart from the operator's targets.
// Both are counters from 1, so they would meet without it.
const RETURN_KEYS: u64 = 1 << 62;

/// Writes the change to the log.
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
