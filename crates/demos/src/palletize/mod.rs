//! Bins off a conveyor onto a pallet, the upside-down ones over the flip jig: a
//! table of five states in a file, and a sequence of substeps in each.

mod advance;
mod aim;
mod geometry;
mod memory;
pub mod numbers;
mod obstacles;
mod policy;
mod progress;
mod scene;
mod setup;
mod steps;
mod table;
mod tick;

use std::sync::Arc;

use robocell_task::Kind;

use numbers::PalletizeTask;
use policy::Palletizer;
use setup::PalletizeSetup;

/// Joints of the UR10.
const JOINTS: usize = 6;

/// `kind = "palletize"` and its policy.
pub fn kind() -> Kind<PalletizeTask> {
    Kind::<PalletizeTask>::new("palletize").policy("table", |task, cell| {
        let setup = Arc::new(PalletizeSetup::new(task, cell)?);
        Ok(Box::new(Palletizer::new(setup)))
    })
}
