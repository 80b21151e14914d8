//! Why a core cannot be measured.

use cell_sim::SimError;

/// Why a core cannot be measured.
#[derive(Debug, thiserror::Error)]
pub(crate) enum CoreError {
    /// The cell.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A robot or a cell file.
    #[error(transparent)]
    Model(#[from] cell_model::ModelError),
    /// The scene cannot be set up.
    #[error(transparent)]
    World(#[from] physics_proc::world::WorldError),
    /// RMPflow does not take the robot.
    #[error(transparent)]
    Flow(#[from] rmp::SetupError),
    /// RMPflow does not take an obstacle.
    #[error(transparent)]
    Obstacle(#[from] rmp::ObstacleError),
    /// The results cannot be printed.
    #[error("the results cannot be written: {0}")]
    Output(std::io::Error),
}
