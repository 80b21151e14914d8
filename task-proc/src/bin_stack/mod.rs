//! Bins off a conveyor into nine columns of four, all of them upside down.
//!
//! A bin that opens downward is gripped on its bottom and stacked; one that opens
//! upward is gripped inside, turned over and slid into a holder of rails, let go,
//! gripped again on its bottom and stacked. The matrix of events and states
//! comes from a file; what its cells call is in `turn`. Which slots are taken is
//! seen, not counted: bins that people stack count, too.
//!
//! What is in the hand is let go over its slot or in the holder only. The source
//! lets it fall where it hangs at a reset; here it is put away first, once the
//! pause is over that a reset ends in, and the next one waits for the start.

mod carry;
mod columns;
mod events;
mod memory;
mod names;
mod paths;
mod policy;
mod scene;
mod setup;
mod supply;
mod turn;

use cell_model::Cell;
use cell_model::task_spec::BinStackTask;

use crate::policy::Policy;
use crate::ur10::SetupError;

/// Name of the policy on the command line.
pub const NAME: &str = "matrix";

/// The policy of `cell`.
///
/// # Errors
/// [`SetupError`] where the cell file or the behaviour file does not make a job.
pub fn policy(task: &BinStackTask, cell: &Cell) -> Result<Box<dyn Policy>, SetupError> {
    let setup = setup::BinStackSetup::new(task, cell)?;
    Ok(Box::new(policy::BinStack::new(setup)))
}
