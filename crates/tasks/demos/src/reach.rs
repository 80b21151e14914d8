//! Following the operator: the arm moves to the target of the panel.

use cell_model::{Cell, Checker, ModelError};
use ipc_types::Text;
use robocell_skills::{FollowOperator, Progress, Setup, Skill, World};
use robocell_task::{ArmIntent, Job, Kind, Observation, Output, Policy, Pose, Settings, boxed};
use schemars::JsonSchema;
use serde::Deserialize;

use crate::check;

/// Follow the operator's target.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ReachTask {
    /// First target of the first arm: TCP position in the world frame (m); it
    /// holds where it is missing.
    pub position_m: Option<[f64; 3]>,
    /// Its orientation, w x y z; position only where it is missing.
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
}

/// `kind = "reach"` and its policy.
pub fn kind() -> Kind<ReachTask> {
    Kind::<ReachTask>::new("reach").policy("follow", |task, cell| {
        let (task, setup) = (task.clone(), Setup::new(cell, []));
        Ok(boxed(Follow { task, setup }))
    })
}

/// Follows panel targets and gripper requests at all times, paused or not. Until the first
/// request the first arm moves to the target of the cell file.
struct Follow {
    task: ReachTask,
    setup: Setup,
}

impl Policy for Follow {
    /// TCP orientation at the first decision, for a first target without one.
    type Memory = Option<[f64; 4]>;

    fn decide(
        &self,
        first: &mut Option<[f64; 4]>,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        out.phase = Text::new("FOLLOW");
        for arm in 0..self.setup.arms.len() {
            if self.setup.arms.get(arm).is_some_and(|arm| arm.is_absent) {
                continue;
            }
            let mut world = World::new(&self.setup, observation, job, out, arm);
            FollowOperator.step(&mut Progress::default(), &mut world);
            // `target_seq` 0: no operator has set a target yet.
            let waits = arm == 0 && observation.panel().target_seq == 0;
            let position = self.task.position_m.filter(|_| waits);
            if let Some((position, tcp)) = position.zip(world.tcp()) {
                // The orientation of the first decision is kept; that of the moving tool would
                // follow itself.
                let found = *first.get_or_insert(tcp.orientation_wxyz);
                let orientation_wxyz = self.task.orientation_wxyz.unwrap_or(found);
                let target = Pose {
                    position,
                    orientation_wxyz,
                };
                world.act(ArmIntent::pose(0, target));
            }
        }
    }

    fn follows_operator(&self) -> bool {
        true
    }

    /// The panel has the whole state: levels, not events (ADR 0001), so nothing can be missed.
    fn reconcile(&self, _: &mut Self::Memory, _: &Observation<'_>, _: &mut Job, _: &mut Output) {}
}
