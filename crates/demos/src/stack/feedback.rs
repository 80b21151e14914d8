//! Grades how the previous command was obeyed.

use ipc_types::decision::GoalKind;
use ipc_types::{GripperGoal, Pose};
use nalgebra::Vector3;

use super::geometry;
use super::phase::{Feedback, Phase};
use super::scene::{ARM, View};
use super::setup::StackSetup;
use robocell_task::goal_book::PreviousGoal;
use robocell_task::observation::Observation;

/// Judges the measured TCP against the *previous* goal's target. `key` names the
/// phase entry that is being judged: what was said for an earlier one, or by
/// the operator, says nothing about this phase, and neither does a controller
/// that has not latched this goal yet. So the tick after a change of phase never
/// counts the old target as reached. Only the goal's number is compared, not
/// its generation: numbers are kept over a restart.
pub fn grade(
    setup: &StackSetup,
    phase: Phase,
    key: u64,
    previous: Option<PreviousGoal>,
    observation: &Observation<'_>,
    scene: &View,
) -> Feedback {
    let Some(previous) = previous.filter(|p| p.key == key && p.kind == GoalKind::Pose) else {
        return Feedback::default();
    };
    let followed = observation
        .echo(ARM)
        .is_some_and(|e| e.goal_active && e.goal_id == previous.goal_id);
    let at_target = observation
        .tcp(ARM)
        .is_some_and(|tcp| near(setup, phase, &tcp, &previous.target));
    let open = scene.gripper_width >= setup.spec.open_width_m - setup.spec.gripper_tolerance_m;
    Feedback {
        target_reached: followed && at_target,
        gripper_reached: open == (previous.gripper == GripperGoal::Open),
    }
}

fn near(setup: &StackSetup, phase: Phase, tcp: &Pose, target: &Pose) -> bool {
    let distance = (Vector3::from(tcp.position) - Vector3::from(target.position)).norm();
    let angle = geometry::angle_between(tcp.orientation_wxyz, target.orientation_wxyz);
    distance < geometry::tolerance(setup, phase) && angle < setup.spec.orientation_tolerance_rad
}
