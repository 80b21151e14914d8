//! Errors of the benches.

use std::path::PathBuf;

use cell_sim::SimError;
use supervisor::failure::Failure;

/// Reasons why control or physics cannot be measured.
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
    /// A cell without the arm that is measured.
    #[error("the cell `{0}` has no arm")]
    NoArm(&'static str),
    /// The joints of a robot do not fit together.
    #[error(transparent)]
    Chain(#[from] rmp::ChainError),
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

/// Reasons why a fleet cannot be measured.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FleetError {
    /// A cell in this process.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A robot or a cell file.
    #[error(transparent)]
    Model(#[from] cell_model::ModelError),
    /// A scene that cannot be set up.
    #[error(transparent)]
    World(#[from] physics_proc::world::WorldError),
    /// A cell of processes.
    #[error(transparent)]
    Cell(#[from] Failure),
    /// An episode that did not run.
    #[error("an episode cannot be measured: {0}")]
    Episode(String),
    /// A thread with a cell.
    #[error("a thread of the bench panicked; its message is above")]
    Panicked,
    /// A program that does not start.
    #[error("{}: {source}; `cargo build --release --workspace --bins` builds it", path.display())]
    Program {
        /// Expected path.
        path: PathBuf,
        /// Reason.
        source: std::io::Error,
    },
    /// A cell whose processes do not come up.
    #[error(
        "cell `{0}` did not start within 60 s; `robocell run franka-stack --headless` says why"
    )]
    NotUp(String),
    /// Path of this program.
    #[error("the path of this program cannot be read: {0}")]
    Own(std::io::Error),
    /// The results cannot be printed.
    #[error("the results cannot be written: {0}")]
    Output(std::io::Error),
}
