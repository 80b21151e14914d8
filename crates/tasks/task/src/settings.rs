//! The settings of a kind of `[task]`, and the error of a job that cannot be made.

use std::borrow::Cow;

use cell_model::{Cell, Checker, ModelError};
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// The table of a kind of `[task]`. Derive `Deserialize` with
/// `deny_unknown_fields`, so that the error of a typing mistake names the right key,
/// and `JsonSchema` for editors. `#[schemars(range(min = .., max = ..))]` on a
/// number, or `#[schemars(inner(range(..)))]` on an array of them, is in the schema
/// and is checked before [`Settings::check`].
pub trait Settings: DeserializeOwned + JsonSchema + Send + Sync + 'static {
    /// Refuses names that do not exist in the cell, and numbers that contradict each other;
    /// `at` makes the error.
    ///
    /// # Errors
    /// [`ModelError`] with file, line, key, value and the allowed values.
    fn check(&self, _cell: &Cell, _at: &Checker<'_>) -> Result<(), ModelError> {
        Ok(())
    }

    /// Force with which the operator closes the gripper (N); by default that of the robot
    /// of the first arm.
    fn grip_force_n(&self, cell: &Cell) -> f64 {
        let gripper = cell.arms.first().and_then(|arm| arm.robot.gripper.as_ref());
        gripper.map_or(0.0, |gripper| gripper.default_force)
    }
}

/// A `[task]` with nothing but its kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NoSettings {}

impl Settings for NoSettings {}

/// Why a job cannot be made of a cell and its files.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct SetupError(String);

impl SetupError {
    /// For `cell`; `problem` states the mistake and the correction.
    pub fn new(cell: &Cell, problem: impl Into<String>) -> Self {
        let file = cell.name_of(&format!("{}.toml", cell.name));
        Self(format!("{file}: {}", problem.into()))
    }

    /// For a file that the cell names; `problem` starts with its name.
    pub fn in_file(problem: impl Into<String>) -> Self {
        Self(problem.into())
    }
}

/// The text of the behaviour file that `task.behaviour` names.
///
/// # Errors
/// [`SetupError`] where it is not in `cells/`, or unreadable.
pub fn behaviour_text(cell: &Cell, name: &str) -> Result<Cow<'static, str>, SetupError> {
    let text = cell.read(name);
    text.map_err(|error| SetupError::new(cell, format!("task.behaviour: {error}")))
}
