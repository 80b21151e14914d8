//! Hold a bin under the dispenser until the grip breaks, and find it again.
//!
//! An event x state matrix from a file, with the eight events and four states of
//! the source. The bin is picked from its stand, lifted under the dispenser and
//! held while parts fall in, until weight or a blow breaks the grip. It falls,
//! spills, is found wherever a flat side of it can be gripped, and held again.

mod events;
mod grasp;
mod hold;
mod memory;
mod names;
mod policy;
mod scene;
mod setup;
#[cfg(test)]
mod tests;
mod turn;

use cell_model::Cell;
use cell_model::task_spec::FillBinTask;

use crate::policy::Policy;
use crate::ur10::SetupError;
use policy::FillBin;
use setup::FillBinSetup;

/// Name of the policy on the command line.
pub const NAME: &str = "matrix";

/// The policy of `cell`.
///
/// # Errors
/// [`SetupError`] where the cell file or the behaviour file does not make a job.
pub fn policy(task: &FillBinTask, cell: &Cell) -> Result<Box<dyn Policy>, SetupError> {
    Ok(Box::new(FillBin::new(FillBinSetup::new(task, cell)?)))
}
