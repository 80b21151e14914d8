//! Hold a bin under the dispenser until the grip breaks, and find it again.

use cell_model::Cell;
use cell_model::task_spec::FillBinTask;

use crate::policy::Policy;
use crate::ur10::SetupError;

/// Name of the policy on the command line.
pub const NAME: &str = "matrix";

/// The policy of `cell`.
///
/// # Errors
/// [`SetupError`] where the cell file or the behaviour file does not make a job.
pub fn policy(_task: &FillBinTask, cell: &Cell) -> Result<Box<dyn Policy>, SetupError> {
    Err(SetupError::new(cell, "there is no such job yet"))
}
