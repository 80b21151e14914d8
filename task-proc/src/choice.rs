//! Which policy a cell's task runs with.

use std::sync::Arc;

use cell_model::task_spec::{ReachTask, StackTask, TaskSpec};
use cell_model::{ArmSpec, Cell};
use nalgebra::Vector2;

use crate::job::Place;
use crate::policy::Policy;
use crate::pyramid::{Json, PyramidError};
use crate::reach::Follow;
use crate::stack::{SetupError, StackSetup, geometry};
use crate::stack_bt::StackBt;
use crate::stack_fsm::StackFsm;
use crate::stack_ifelse::StackIfElse;
use crate::{bin_stack, fill_bin, palletize, ur10};

/// Closing force where neither cell nor robot names one (N).
const DEFAULT_GRIP_FORCE_N: f64 = 20.0;

/// Why a task cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum TaskError {
    /// No such policy for this demo.
    #[error("there is no policy '{policy}' for demo '{demo}'; {advice}")]
    UnknownPolicy {
        /// What was asked for.
        policy: String,
        /// The demo.
        demo: String,
        /// The nearest name, or all of them.
        advice: String,
    },
    /// The cell file's numbers do not make a task.
    #[error("cells/{demo}.toml: {source}")]
    Setup {
        /// The demo.
        demo: String,
        /// What is wrong.
        source: SetupError,
    },
    /// The cell file, or a behaviour it names, does not make a task.
    #[error("cells/{demo}.toml: {source}")]
    Pyramid {
        /// The demo.
        demo: String,
        /// What is wrong.
        source: Box<PyramidError>,
    },
    /// A job of the UR10 cannot be made.
    #[error(transparent)]
    Ur10(#[from] ur10::SetupError),
    /// Nobody to do it.
    #[error("cells/{demo}.toml has no [[arm]]; a task needs one")]
    NoArm {
        /// The demo.
        demo: String,
    },
}

/// A policy, and the force the operator closes the gripper with (N).
type Choice = Result<(Box<dyn Policy>, f64), TaskError>;

/// The named policy of the cell's task.
pub(crate) fn choose(cell: &Cell, policy: &str) -> Choice {
    let arm = cell.arms.first().ok_or_else(|| TaskError::NoArm {
        demo: cell.name.clone(),
    })?;
    match &cell.task {
        TaskSpec::Stack(spec) => stack(spec, cell, arm, policy),
        TaskSpec::Pyramid(spec) => {
            only(cell, policy, Json::NAME)?;
            let policy = Json::new(spec, cell).map_err(|source| TaskError::Pyramid {
                demo: cell.name.clone(),
                source: Box::new(source),
            })?;
            Ok((Box::new(policy), spec.grip_force_n))
        }
        TaskSpec::Reach(spec) => reach(spec, cell, arm, policy),
        TaskSpec::Palletize(spec) => {
            only(cell, policy, palletize::NAME)?;
            Ok((palletize::policy(spec, cell)?, 0.0))
        }
        TaskSpec::FillBin(spec) => {
            only(cell, policy, fill_bin::NAME)?;
            Ok((fill_bin::policy(spec, cell)?, 0.0))
        }
        TaskSpec::BinStack(spec) => {
            only(cell, policy, bin_stack::NAME)?;
            Ok((bin_stack::policy(spec, cell)?, 0.0))
        }
    }
}

fn stack(spec: &StackTask, cell: &Cell, arm: &ArmSpec, policy: &str) -> Choice {
    let base = Vector2::new(arm.base.translation.x, arm.base.translation.y);
    let broken = |source| TaskError::Setup {
        demo: cell.name.clone(),
        source,
    };
    let setup = StackSetup::new(spec, &spawn_places(cell), base).map_err(broken)?;
    let setup = Arc::new(setup);
    let policy: Box<dyn Policy> = match policy {
        StackFsm::NAME => Box::new(StackFsm::new(setup)),
        StackIfElse::NAME => Box::new(StackIfElse::new(setup)),
        StackBt::NAME => Box::new(StackBt::new(setup).map_err(broken)?),
        _ => {
            let known = [StackFsm::NAME, StackIfElse::NAME, StackBt::NAME];
            return Err(unknown(cell, policy, &known));
        }
    };
    Ok((policy, spec.grip_force_n))
}

fn reach(spec: &ReachTask, cell: &Cell, arm: &ArmSpec, policy: &str) -> Choice {
    only(cell, policy, Follow::NAME)?;
    let force = arm.robot.gripper.as_ref().map(|g| g.default_force);
    let force = force.unwrap_or(DEFAULT_GRIP_FORCE_N);
    Ok((Box::new(Follow::new(spec.clone(), force)), force))
}

fn spawn_places(cell: &Cell) -> Vec<(&str, Place)> {
    let place = |pose: &nalgebra::Isometry3<f64>| {
        let q = pose.rotation.quaternion();
        let position = pose.translation.vector.into();
        let wire = ipc_types::Pose {
            position,
            orientation_wxyz: [q.w, q.i, q.j, q.k],
        };
        Place {
            position,
            yaw: geometry::yaw(&wire),
        }
    };
    cell.objects
        .iter()
        .map(|o| (o.name.as_str(), place(&o.pose)))
        .collect()
}

/// Refuses all policies but one.
fn only(cell: &Cell, policy: &str, known: &str) -> Result<(), TaskError> {
    if policy == known {
        Ok(())
    } else {
        Err(unknown(cell, policy, &[known]))
    }
}

fn unknown(cell: &Cell, policy: &str, known: &[&str]) -> TaskError {
    TaskError::UnknownPolicy {
        policy: policy.to_owned(),
        demo: cell.name.clone(),
        advice: cell_model::suggest::advice(policy, known),
    }
}
