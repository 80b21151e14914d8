//! The operator's panel of a task: its requests, and the arms while the operator leads.

use ipc_types::trace::TraceEvent;
use ipc_types::{OperatorPanel, Text};

use super::Task;
use crate::operator::{PanelChange, log_change};
use crate::output::ArmIntent;

impl Task {
    /// Whether the arms follow the operator instead of the policy.
    pub(super) fn is_led(&self, panel: &OperatorPanel) -> bool {
        // A policy whose job are the operator's targets keeps the arm in a pause, except for
        // the return to the default pose after a reset.
        let returns = (0..self.arm_count).any(|arm| self.panel.returns(panel, arm));
        self.panel.paused() && (returns || !self.policy.follows_operator())
    }

    /// The arm that the operator's panel names follows the operator; after a reset of the
    /// task the others return to their default pose.
    pub(super) fn lead(&mut self, panel: &OperatorPanel, tick: u64) {
        // Obstacles that are not solid guide the paths of a policy; the operator may want to
        // move the arm through them.
        let obstacle_mask = self.solid_obstacles;
        let (led, asked) = self.panel.lead(panel, self.grip_force);
        for (arm, home) in self.homes.iter().enumerate() {
            let intent = if self.panel.returns(panel, arm) {
                let pose = self.policy.default_pose(arm);
                self.panel.to_default(panel, tick, pose, *home)
            } else if arm == led {
                asked
            } else {
                // No intent: the arm holds and keeps its gripper.
                continue;
            };
            self.out.arm(
                arm,
                ArmIntent {
                    obstacle_mask,
                    ..intent
                },
            );
        }
    }

    pub(super) fn apply(&mut self, change: PanelChange, panel: &OperatorPanel) {
        log_change(change, &mut self.out);
        if change.reset {
            self.policy.reset();
            self.job.reset();
            self.phase = Text::EMPTY;
            // `forget` and not a new book: goal numbers must not repeat.
            self.out.book_mut().forget();
            self.out.forget_message();
            // The gripper may hold an object.
            self.unsure = true;
            // A level of the panel: a job that was started before the reset waits for no second
            // start.
            self.job.started = panel.task_started == 1;
        }
        self.job.started |= change.start;
        if change.start && self.job.failure.is_some() {
            self.job.retry();
            self.out.forget_message();
            // The gripper may still hold an object.
            self.unsure = true;
            self.out
                .lifecycle(TraceEvent::Restart, format_args!("[task] started again"));
        }
        if change.resume {
            // The operator may have moved the arm, an object, or the gripper.
            self.unsure = true;
        }
    }
}
