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
pub mod numbers;
mod policy;
mod scene;
mod setup;
#[cfg(test)]
mod tests;
mod turn;

use robocell_task::Kind;

use numbers::FillBinTask;
use policy::FillBin;
use setup::FillBinSetup;

/// `kind = "fill_bin"` and its policy.
pub fn kind() -> Kind<FillBinTask> {
    Kind::<FillBinTask>::new("fill_bin").policy("matrix", |task, cell| {
        Ok(Box::new(FillBin::new(FillBinSetup::new(task, cell)?)))
    })
}
