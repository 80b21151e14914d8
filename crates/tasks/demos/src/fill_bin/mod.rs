//! Holds a bin under the dispenser until the grip breaks, and finds it again.
//!
//! An event x state matrix from a file, with the events and states of Isaac Sim's sample. The
//! bin is picked from its stand, lifted under the dispenser and held while parts fall in, until
//! their weight or an impact breaks the grip. It falls, spills, is found wherever a flat side
//! of it can be gripped, and is held again. The job is done then, and stays done until a reset,
//! while the cycle of bin and parts continues.

mod events;
mod grasp;
mod handlers;
mod hold;
mod job;
pub mod numbers;
#[cfg(test)]
mod tests;

use robocell_skills::matrix;
use robocell_task::Kind;

use job::FillBin;
use numbers::FillBinTask;

/// `kind = "fill_bin"` and its policy.
pub fn kind() -> Kind<FillBinTask> {
    Kind::<FillBinTask>::new("fill_bin").policy("matrix", |task, cell| {
        matrix::policy(FillBin::new(task, cell)?, cell, &task.behaviour)
    })
}
