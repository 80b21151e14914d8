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
pub mod numbers;
mod paths;
mod policy;
mod scene;
mod setup;
mod supply;
mod turn;

use robocell_task::Kind;

use numbers::BinStackTask;
use policy::BinStack;
use setup::BinStackSetup;

/// `kind = "bin_stack"` and its policy.
pub fn kind() -> Kind<BinStackTask> {
    Kind::<BinStackTask>::new("bin_stack").policy("matrix", |task, cell| {
        Ok(Box::new(BinStack::new(BinStackSetup::new(task, cell)?)))
    })
}
