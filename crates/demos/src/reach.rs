//! Following the operator: the arm goes where the panel's target is.

use cell_model::{Cell, Checker, ModelError};
use ipc_types::decision::GoalKind;
use ipc_types::{GripperGoal, MAX_ARMS, Pose};
use robocell_task::job::Job;
use robocell_task::observation::Observation;
use robocell_task::operator::{operator_target, requested_gripper};
use robocell_task::output::{ArmIntent, Output};
use robocell_task::{Kind, Policy, Settings, boxed};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check;

/// Closing force where the robot names none (N).
const DEFAULT_GRIP_FORCE_N: f64 = 20.0;
/// The one phase.
const FOLLOW: &str = "FOLLOW";

/// Follow the operator's target.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachTask {
    /// First target: TCP position in the world frame (m); the home pose of the
    /// robot where it is missing.
    #[serde(default)]
    pub position_m: Option<[f64; 3]>,
    /// Its orientation, w x y z; position only where it is missing.
    #[serde(default)]
    pub orientation_wxyz: Option<[f64; 4]>,
}

impl Settings for ReachTask {
    fn check(&self, _cell: &Cell, at: &Checker<'_>) -> Result<(), ModelError> {
        if let Some(position) = &self.position_m {
            at.position("task.position_m", position)?;
        }
        let orientation = self.orientation_wxyz.as_ref();
        orientation.map_or(Ok(()), |orientation| {
            check::unit_quaternion(at, "task.orientation_wxyz", orientation, 1.0e-6)
        })
    }

    fn grip_force_n(&self, cell: &Cell) -> f64 {
        let gripper = cell.arms.first().and_then(|arm| arm.robot.gripper.as_ref());
        gripper.map_or(DEFAULT_GRIP_FORCE_N, |gripper| gripper.default_force)
    }
}

/// `kind = "reach"` and its policy.
pub fn kind() -> Kind<ReachTask> {
    Kind::<ReachTask>::new("reach").policy("follow", |task, cell| {
        Ok(boxed(Follow::new(task.clone(), task.grip_force_n(cell))))
    })
}

/// Follows panel targets and gripper requests always, paused or not. Until the
/// first one it goes to the target of the cell file, or holds without one.
#[derive(Clone, Debug)]
pub struct Follow {
    task: ReachTask,
    grip_force: f64,
}

/// TCP orientation at the first decision, for a first target without one.
type FirstOrientation = Option<[f64; 4]>;

impl Follow {
    /// `grip_force` is used when the operator closes the gripper (N).
    pub fn new(task: ReachTask, grip_force: f64) -> Self {
        Self { task, grip_force }
    }

    fn first_target(
        &self,
        first: &mut FirstOrientation,
        observation: &Observation<'_>,
    ) -> Option<ArmIntent> {
        let position = self.task.position_m?;
        let measured = observation.tcp(0)?.orientation_wxyz;
        let kept = *first.get_or_insert(measured);
        let orientation_wxyz = self.task.orientation_wxyz.unwrap_or(kept);
        let target = Pose {
            position,
            orientation_wxyz,
        };
        Some(ArmIntent {
            kind: GoalKind::Pose,
            target,
            ..ArmIntent::default()
        })
    }
}

impl Policy for Follow {
    type Memory = FirstOrientation;

    fn decide(
        &self,
        first: &mut FirstOrientation,
        observation: &Observation<'_>,
        _job: &mut Job,
        out: &mut Output,
    ) {
        let panel = observation.panel();
        let given = panel.target_seq > 0;
        // The panel names one arm; the other ones hold.
        let arm = if given {
            (panel.target_arm as usize).min(MAX_ARMS - 1)
        } else {
            0
        };
        let mut intent = if given {
            Some(operator_target(panel))
        } else {
            self.first_target(first, observation)
        }
        .unwrap_or_default();
        if panel.gripper_seq > 0 {
            intent.gripper = requested_gripper(panel);
            if intent.gripper == GripperGoal::Close {
                intent.grip_force = self.grip_force;
            }
        }
        out.arm(arm, intent);
    }

    fn phase(&self, _first: &FirstOrientation) -> &str {
        FOLLOW
    }

    fn phases(&self) -> &[&str] {
        &[FOLLOW]
    }

    fn follows_operator(&self) -> bool {
        true
    }

    fn reconcile(
        &self,
        _first: &mut FirstOrientation,
        _observation: &Observation<'_>,
        _job: &mut Job,
        _out: &mut Output,
    ) {
    }
}
