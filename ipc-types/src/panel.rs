//! The operator's panel, as part of a state.

use crate::pose::Pose;
use crate::validate::{Check, Invalid, MAX_EFFORT, MAX_JOINT_POSITION, code};
use crate::wire::wire;
use crate::{BreakName, MAX_ARMS, MAX_BREAKS, MAX_JOINTS};

code! {
    /// Reason why simulated time is paused.
    pub enum PauseCause {
        /// It is not paused.
        None = 0,
        /// The scene was set up paused.
        Start = 1,
        /// A person or a script requested it.
        Operator = 2,
        /// The ticks of a step are done.
        Step = 3,
        /// The task reached a breakpoint.
        Breakpoint = 4,
    }
}

wire! {
    /// The operator's panel: requests of people as levels and counters, so that a reader that
    /// missed a state misses no request (ADR 0001).
    pub struct OperatorPanel {
        /// Counts start requests to the task; with `--until-done` the run itself
        /// makes the first.
        pub task_start: u32,
        /// 1 from a start request until the next reset of the task.
        pub task_started: u32,
        /// [`PauseCause`] of the pause that is in force.
        pub pause_cause: u32,
        /// Counts reset requests to the task.
        pub task_reset: u32,
        /// 1 while the operator has paused the task.
        pub task_paused: u32,
        /// Arm `target` is for.
        pub target_arm: u32,
        /// Counts targets given; 0: never.
        pub target_seq: u32,
        /// Counts gripper requests; 0: never.
        pub gripper_seq: u32,
        /// [`crate::GripperGoal`] of the newest gripper request.
        pub gripper: u32,
        /// Counts requests to drop parts.
        pub drop_parts: u32,
        /// Counts requests for a bin.
        pub add_bin: u32,
        /// Counts resets of the scene: a process that integrates or keeps state starts again
        /// from the measured state.
        pub scene_reset: u32,
        /// 1 where the newest target is `target_joints`, 0 where it is `target`.
        pub target_is_joints: u32,
        /// Valid entries of `breaks`.
        pub break_count: u32,
        /// Counts targets that ended at a contact; 0: never.
        pub contact_stops: u32,
        /// The body that pressed most in the last of them, as in [`crate::contact::Contact`].
        pub contact_with: u32,
        /// TCP target in the world frame, valid when `target_seq` > 0.
        pub target: Pose,
        /// Joint target, in the order of the controlled joints; rad or m.
        pub target_joints: [f64; MAX_JOINTS],
        /// Requested simulated seconds per second; 1: real time, 0: as fast as possible.
        pub speed: f64,
        /// Contact force at which the target in force ends (N).
        pub contact_limit: f64,
        /// Contact force of the last contact stop (N).
        pub contact_force: f64,
        /// Breakpoints: names of nodes, states and guards of the task's graphs.
        pub breaks: [BreakName; MAX_BREAKS],
    }
}

impl OperatorPanel {
    /// The breakpoints.
    pub fn breaks(&self) -> &[BreakName] {
        &self.breaks[..(self.break_count as usize).min(MAX_BREAKS)]
    }

    pub(crate) fn check(&self) -> Result<(), Invalid> {
        // Before the first target the pose is all zeros, which is not a valid one.
        if self.target_seq > 0 {
            self.target.check()?;
        }
        Check::code(
            "panel.pause_cause",
            self.pause_cause,
            PauseCause::from_code(self.pause_cause).is_some(),
        )?;
        Check::count("panel.target_arm", self.target_arm, MAX_ARMS - 1)?;
        Check::within(
            "panel.target_joints",
            &self.target_joints,
            MAX_JOINT_POSITION,
        )?;
        // A larger factor is a mistake; 0 means as fast as possible.
        Check::within("panel.speed", &[self.speed], 50.0)?;
        Check::within("panel.contact_limit", &[self.contact_limit], MAX_EFFORT)?;
        Check::within("panel.contact_force", &[self.contact_force], MAX_EFFORT)?;
        Check::count("panel.break_count", self.break_count, MAX_BREAKS)?;
        for name in self.breaks() {
            name.check("panel.breaks")?;
        }
        Check::code(
            "panel.gripper",
            self.gripper,
            crate::GripperGoal::from_code(self.gripper).is_some(),
        )
    }
}
