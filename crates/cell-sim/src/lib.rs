//! The cores of a cell in one process, without a bus: the same seed and script
//! give the same state hash as four processes in lockstep.
#![forbid(unsafe_code)]

pub mod behaviour;
pub mod bench;
mod bench_mujoco;
mod bench_piles;
pub mod eval;
pub mod one_process;
pub mod run;
pub mod verify;

pub use one_process::OneProcess;

/// Why a cell cannot run in this process.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// The run file.
    #[error(transparent)]
    Spec(#[from] cell_model::run_spec::RunSpecError),
    /// The cell file or a robot.
    #[error(transparent)]
    Model(#[from] cell_model::ModelError),
    /// The scene cannot be set up.
    #[error(transparent)]
    World(#[from] physics_proc::world::WorldError),
    /// The controller does not fit the robot.
    #[error(transparent)]
    Controller(#[from] controller_proc::rmpflow_controller::RmpFlowError),
    /// The policy.
    #[error(transparent)]
    Task(#[from] task_proc::TaskError),
    /// A script that cannot be read.
    #[error("{path}: {source}")]
    ScriptFile {
        /// The file.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// A script with a wrong line.
    #[error(transparent)]
    Script(#[from] cell_model::script::ScriptError),
    /// A behaviour that is not right, all of it.
    #[error("{0}")]
    Behaviour(String),
    /// There is no such bench.
    #[error("there is no bench '{0}' of a core; there are control and physics")]
    UnknownBench(String),
    /// RMPflow does not take the robot.
    #[error(transparent)]
    Flow(#[from] rmp::SetupError),
    /// RMPflow does not take an obstacle.
    #[error(transparent)]
    Obstacle(#[from] rmp::ObstacleError),
    /// Nobody takes the results.
    #[error("the results cannot be written: {0}")]
    Output(std::io::Error),
    /// A recording that cannot be verified.
    #[error(transparent)]
    Verify(#[from] verify::VerifyError),
    /// A record of the task that the task does not take back.
    #[error(transparent)]
    Record(#[from] task_proc::RecordError),
}
