//! Why a task cannot be made.

use cell_model::{Location, ModelError};

use crate::settings::SetupError;

/// Why a task cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum TaskError {
    /// No such kind of `[task]` in this program.
    #[error("{at}: task.kind is '{kind}', which this task program does not know; {advice}")]
    UnknownKind {
        /// The line of the cell file.
        at: Location,
        /// The kind that the file names.
        kind: String,
        /// The nearest name, or all of them.
        advice: String,
    },
    /// No such policy for this kind.
    #[error("{refusal}")]
    UnknownPolicy {
        /// The requested name, and the nearest known name or all of them.
        refusal: String,
    },
    /// The `[task]` table.
    #[error(transparent)]
    Settings(#[from] ModelError),
    /// The cell, or a behaviour it names, does not make this job.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// The cell has no arm.
    #[error("cells/{demo}.toml has no [[arm]]; a task needs one")]
    NoArm {
        /// The demo.
        demo: String,
    },
}
