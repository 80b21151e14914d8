//! What the leaves of the stacking tree see and reach during a tick.

use behavior::tree::Host;
use ipc_types::GripperGoal;

use crate::stack::{Phase, StackSetup, View};
use robocell_task::job::Job;
use robocell_task::observation::Observation;
use robocell_task::output::{ArmIntent, Output};
use robocell_task::time::PolicyTime;

/// Names the world.
pub struct StackHost;

/// The observation, the job, and the decision being made.
pub struct StackWorld<'w> {
    /// The numbers of the cell file.
    pub setup: &'w StackSetup,
    /// Cubes, tool and gripper.
    pub scene: &'w View,
    /// The whole sample.
    pub observation: &'w Observation<'w>,
    /// Policy time.
    pub now: PolicyTime,
    /// Decisions were missed, so a target that was reached may not be any more.
    pub unsettled: bool,
    /// What all policies know.
    pub job: &'w mut Job,
    /// Log lines and the previous goal.
    pub out: &'w mut Output,
    /// What the leaf that ran last wants; none: hold.
    pub intent: Option<(Phase, ArmIntent)>,
    /// What the gripper does in a decision without a phase.
    pub gripper: GripperGoal,
}

impl Host for StackHost {
    type World<'w> = StackWorld<'w>;
}
