//! How a run ended.

use cell_run::summary::RunSummary;

use super::plan::Plan;
use crate::failure::Failure;

/// How a run ended.
pub enum End {
    /// With the task, or at its time limit.
    Finished(Box<RunSummary>),
    /// On request, with the summary at that time; `None` if physics never ran.
    Stopped(Option<Box<RunSummary>>),
    /// Because another scene was asked for.
    Replaced(Box<Plan>),
    /// Because a process could not be kept running, or refused the cell.
    GaveUp(Failure),
}
