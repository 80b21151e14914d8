//! What the jobs of the UR10 have in common: poses of the suction cup, paths of
//! waypoints and when they count as reached, and what becomes of a grip.

mod grip_events;
mod motion;
pub mod pose;
mod precision;
mod waypoint;

use cell_model::Cell;

pub use grip_events::{GripChange, GripMemory};
pub use motion::{Motion, Reached};
pub use precision::{PASSING, Precision, ROWS};
pub use waypoint::{JOINTS, MAX_WAYPOINTS, Waypoint};

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
