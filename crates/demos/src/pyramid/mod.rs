//! Two arms take a pyramid of cubes apart, each after one behaviour tree that is
//! written in a file: one file, an instance for each arm.
//!
//! The trees share a blackboard. A cube is reserved by one arm at a time, and
//! one arm at a time owns the centre, where the pyramid stands. What an arm
//! believes about its stack is compared with what is seen whenever it matters,
//! so nothing is counted twice and nothing is lost without being noticed.

mod center;
mod cubes;
mod grip;
mod host;
mod keys;
mod library;
mod nodes;
pub mod numbers;
mod phases;
mod policy;
mod setup;
mod targets;

#[cfg(test)]
mod tests;

use std::sync::Arc;

use cell_model::{Cell, Data};
use robocell_task::{Kind, SetupError, TaskError};

pub use host::{PyramidHost, World};
pub use library::library;
pub use policy::Json;
pub use setup::{ArmSetup, CubeSetup, PyramidError, PyramidSetup};

use numbers::PyramidTask;

/// The demo from whose cell a tree in a file takes the cubes and arms it names.
const DEMO: &str = "franka-pyramid";

/// `kind = "pyramid"` and its policy.
pub fn kind() -> Kind<PyramidTask> {
    Kind::<PyramidTask>::new("pyramid")
        .policy("json", |task, cell| {
            let policy = Json::new(task, cell);
            Ok(Box::new(policy.map_err(|error| {
                SetupError::new(cell, error.to_string())
            })?))
        })
        .trees(|data: &Data| {
            let cell = Cell::load(data, DEMO, 0, None)?;
            let task: PyramidTask = cell.task.read()?;
            let setup = PyramidSetup::new(&task, &cell);
            let setup = setup
                .map_err(|error| TaskError::from(SetupError::new(&cell, error.to_string())))?;
            Ok(library(&Arc::new(setup)))
        })
}
