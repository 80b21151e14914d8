//! Bins off a conveyor onto a pallet, the upside-down ones over the flip jig: a
//! table of five states in a file, and a sequence of substeps in each.

mod advance;
mod aim;
mod geometry;
mod obstacles;
mod policy;
mod progress;
mod record;
mod scene;
mod setup;
mod steps;
mod table;
mod tick;

use std::sync::Arc;

use cell_model::Cell;
use cell_model::task_spec::PalletizeTask;

use crate::policy::Policy;
use crate::ur10::SetupError;
use policy::Palletizer;
use setup::PalletizeSetup;

/// Name of the policy on the command line.
pub const NAME: &str = "table";

/// The policy of `cell`.
///
/// # Errors
/// [`SetupError`] where the cell file or the behaviour file does not make a job.
pub fn policy(task: &PalletizeTask, cell: &Cell) -> Result<Box<dyn Policy>, SetupError> {
    let setup = Arc::new(PalletizeSetup::new(task, cell)?);
    Ok(Box::new(Palletizer::new(setup)))
}
