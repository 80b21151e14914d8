//! Bins off a conveyor into nine columns of four, all of them upside down.
//!
//! A bin that opens downward is gripped on its bottom and stacked; one that opens
//! upward is gripped inside, turned over and slid into a holder of rails, let go,
//! gripped again on its bottom and stacked. The matrix of events and states
//! comes from a file; what its cells call is in `handlers` and `carry`. Which slots
//! are taken is seen, not counted: bins that people stack count, too.
//!
//! What is in the gripper is released over its slot or in the holder only. Isaac Sim's sample
//! lets it fall where it hangs at a reset; here it is put away first, once the
//! pause is over that a reset ends in, and the next one waits for the start.

mod carry;
mod columns;
mod handlers;
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
