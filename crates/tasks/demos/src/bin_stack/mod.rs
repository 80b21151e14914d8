//! Stacks bins from a conveyor in nine columns of four, all of them upside down.
//!
//! A bin that opens downward is gripped on its bottom and stacked. One that opens upward is
//! gripped inside, turned over, slid into a holder of rails, released, gripped again on its
//! bottom and stacked. The matrix of events and states is read from a file; its cells name
//! handlers in `handlers` and `carry`. Which slots are taken is observed, not counted, so bins
//! that people stack count, too.
//!
//! A held bin is released over its slot or in the holder only. Isaac Sim's sample drops it at
//! its present place at a reset; here it is set down in its place first, once the pause is over
//! in which a reset ends, and the next bin waits for the start.

mod carry;
mod columns;
mod events;
mod handlers;
mod home;
mod job;
pub mod numbers;
mod paths;
mod scene;
mod supply;

use robocell_skills::matrix;
use robocell_task::Kind;

use job::BinStack;
use numbers::BinStackTask;

/// `kind = "bin_stack"` and its policy.
pub fn kind() -> Kind<BinStackTask> {
    Kind::<BinStackTask>::new("bin_stack").policy("matrix", |task, cell| {
        matrix::policy(BinStack::new(task, cell)?, cell, &task.behaviour)
    })
}
