//! What the jobs of the UR10 have in common.

use cell_model::Cell;

/// Why a job cannot be made.
#[derive(Debug, thiserror::Error)]
#[error("cells/{demo}.toml: {problem}")]
pub struct SetupError {
    demo: String,
    problem: String,
}

impl SetupError {
    /// Of `cell`, with what is wrong and what to do.
    pub fn new(cell: &Cell, problem: impl Into<String>) -> Self {
        Self {
            demo: cell.name.clone(),
            problem: problem.into(),
        }
    }
}
