//! Why a subcommand of a task program fails.

use cell_sim::SimError;

use crate::camera::CameraError;
use crate::inspect::InspectError;
use crate::recordings::RecordingError;
use crate::rows::RowsError;

/// Why a subcommand fails.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CliError {
    /// A run, or many.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A behaviour.
    #[error(transparent)]
    Inspect(#[from] InspectError),
    /// Rows of many runs.
    #[error(transparent)]
    Rows(#[from] RowsError),
    /// Recordings of failed runs.
    #[error(transparent)]
    Recordings(#[from] RecordingError),
    /// Pictures of cameras.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The files of a robot, which the launcher passes on.
    #[error("--robot: {0}")]
    Robot(#[from] serde_json::Error),
}

impl From<cell_run::spec::RunSpecError> for CliError {
    fn from(error: cell_run::spec::RunSpecError) -> Self {
        Self::Sim(error.into())
    }
}

impl From<cell_model::ModelError> for CliError {
    fn from(error: cell_model::ModelError) -> Self {
        Self::Sim(error.into())
    }
}
