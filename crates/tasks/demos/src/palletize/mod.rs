//! Stacks bins from a conveyor on a pallet, the upside-down ones over the flip jig: a table of
//! five states in a file, and sequences of steps in the cell file.

mod advance;
mod checks;
mod geometry;
mod memory;
mod motion;
pub mod numbers;
mod obstacles;
mod policy;
mod scene;
mod setup;
mod steps;
mod table;
mod waits;
mod work_kind;

use std::sync::Arc;

use robocell_task::Kind;

use numbers::PalletizeTask;
use policy::Palletizer;
use setup::PalletizeSetup;

/// `kind = "palletize"` and its policy.
pub fn kind() -> Kind<PalletizeTask> {
    Kind::<PalletizeTask>::new("palletize").policy("table", |task, cell| {
        let setup = Arc::new(PalletizeSetup::new(task, cell)?);
        Ok(Box::new(Palletizer::new(setup)))
    })
}
