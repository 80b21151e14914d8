//! Decisions that are given, in place of those of a task.

use cell_model::Cell;
use ipc_types::Decision;
use robocell_task::{Job, Observation, Output, Policy, Task, boxed};

/// Writes the decision of a tick.
pub type Decisions = Box<dyn FnMut(u64, &mut Decision) + Send>;

/// The task of such a cell, which is never asked.
pub(crate) fn task(cell: &Cell) -> Task {
    Task::new(cell, "given", 0.0, boxed(Nothing))
}

struct Nothing;

impl Policy for Nothing {
    type Memory = ();

    fn decide(&self, (): &mut (), _: &Observation<'_>, _: &mut Job, _: &mut Output) {}
}
