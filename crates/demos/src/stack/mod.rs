//! Stacking cubes, in three ways: as a library-free state machine, as one
//! if/else controller, and as a tree in code. What they share is beside them;
//! numbers come from `[task]` of the cell file.

pub mod bt;
pub mod command;
pub mod feedback;
pub mod fsm;
pub mod geometry;
pub mod grip;
pub mod ifelse;
pub mod numbers;
pub mod phase;
pub mod picture;
pub mod recovery;
pub mod resume;
pub mod scene;
pub mod selection;
pub mod setup;

use std::sync::Arc;

use cell_model::Cell;
use nalgebra::Vector2;
use robocell_task::job::Placement;
use robocell_task::{Kind, boxed};

pub use phase::Phase;
pub use scene::View;
pub use setup::{SetupError, StackSetup};

use bt::StackBt;
use fsm::StackFsm;
use ifelse::StackIfElse;
use numbers::StackTask;

/// `kind = "stack"` and its policies.
pub fn kind() -> Kind<StackTask> {
    Kind::<StackTask>::new("stack")
        .policy("fsm", |task, cell| {
            Ok(boxed(StackFsm::new(setup_of(task, cell)?)))
        })
        .policy("ifelse", |task, cell| {
            Ok(boxed(StackIfElse::new(setup_of(task, cell)?)))
        })
        .policy("bt", |task, cell| {
            let tree = StackBt::new(setup_of(task, cell)?);
            let tree =
                tree.map_err(|error| robocell_task::SetupError::new(cell, error.to_string()))?;
            Ok(Box::new(tree))
        })
}

fn setup_of(task: &StackTask, cell: &Cell) -> Result<Arc<StackSetup>, robocell_task::SetupError> {
    let base = cell.arms.first().map(|arm| arm.base.translation.vector);
    let base = base.unwrap_or_default();
    let setup = StackSetup::new(task, &spawn_places(cell), Vector2::new(base.x, base.y));
    setup
        .map(Arc::new)
        .map_err(|error| robocell_task::SetupError::new(cell, error.to_string()))
}

fn spawn_places(cell: &Cell) -> Vec<(&str, Placement)> {
    let place = |pose: &nalgebra::Isometry3<f64>| {
        let q = pose.rotation.quaternion();
        let position = pose.translation.vector.into();
        let wire = ipc_types::Pose {
            position,
            orientation_wxyz: [q.w, q.i, q.j, q.k],
        };
        Placement {
            position,
            yaw: geometry::yaw(&wire),
        }
    };
    cell.objects
        .iter()
        .map(|o| (o.name.as_str(), place(&o.pose)))
        .collect()
}
