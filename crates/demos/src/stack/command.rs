//! The commands of the stacking policies.

use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::{GripperGoal, Text};

use super::geometry;
use super::phase::Phase;
use super::recovery::at_goal;
use super::scene::View;
use super::setup::StackSetup;
use robocell_task::job::{Job, Placement};
use robocell_task::output::{ArmIntent, Output};

/// Names of the decisions that belong to no phase.
pub mod idle {
    /// Nothing to do, or not able to.
    pub const HOLD: &str = "HOLD";
    /// Every cube is placed.
    pub const DONE: &str = "DONE";
}

/// The goal of `phase` around `place`. `key` names the phase entry: live targets
/// move under one key, a new phase or destination has a new one.
pub fn intent(setup: &StackSetup, phase: Phase, place: Placement, key: u64) -> ArmIntent {
    ArmIntent {
        kind: GoalKind::Pose,
        gripper: if phase.closed() {
            GripperGoal::Close
        } else {
            GripperGoal::Open
        },
        key,
        target: geometry::tcp_target(setup, phase, place),
        grip_force: setup.spec.grip_force_n,
        ..ArmIntent::default()
    }
}

/// The decision without a phase: hold. Only after a drop the gripper is opened,
/// otherwise it keeps what it has.
pub fn hold(gripper: GripperGoal) -> ArmIntent {
    ArmIntent {
        gripper,
        ..ArmIntent::default()
    }
}

/// Says how the job stands: the phase, the outcome and the cubes in place.
pub fn report(
    setup: &StackSetup,
    scene: &View,
    phase: Option<Phase>,
    job: &mut Job,
    out: &mut Output,
) {
    out.phase = Text::new(match phase {
        Some(phase) => phase.name(),
        None if job.done => idle::DONE,
        None => idle::HOLD,
    });
    out.outcome = if job.done {
        Outcome::Done
    } else {
        Outcome::Running
    };
    job.placed.clear();
    for (index, cube) in setup.cubes.iter().enumerate() {
        if job.held != Some(cube.object) && at_goal(setup, scene, index) {
            job.placed
                .push(u32::try_from(cube.object).unwrap_or(u32::MAX));
        }
    }
}
