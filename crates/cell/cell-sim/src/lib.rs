//! The cores of a cell in one process, without a bus: the same seed and script give the same
//! state hash as four processes in lockstep (ADR 0004).
#![forbid(unsafe_code)]

pub mod action;
pub mod episodes;
pub mod eval;
mod frames;
pub mod gateway;
pub mod given;
pub mod one_process;
mod record;
pub mod run;
pub mod snapshot;
pub mod verify;

pub use one_process::OneProcess;

use cell_model::Data;
pub use controller_proc;

use controller_proc::Controllers;
use gateway::Gateways;
use robocell_task::Policies;

/// Content of a task program: policies, controllers, gateways, and its cells and robots.
#[derive(Clone)]
pub struct Program {
    /// Policies by the kind of `[task]`.
    pub policies: Policies,
    /// Controllers that an arm may name.
    pub controllers: Controllers,
    /// Interfaces to programs of others.
    pub gateways: Gateways,
    /// Where a cell is searched for if the user gave no folder.
    pub data: Data,
}

impl SimError {
    /// The directory of recordings cannot be used.
    pub fn from_dir(dir: &std::path::Path, source: std::io::Error) -> Self {
        let path = dir.to_owned();
        Self::Record(cell_record::RecordError::Io { path, source })
    }
}

/// Why a cell cannot run in this process.
#[derive(Debug, thiserror::Error)]
pub enum SimError {
    /// The run file.
    #[error(transparent)]
    Spec(#[from] cell_run::spec::RunSpecError),
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
    Task(#[from] robocell_task::TaskError),
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
    Script(#[from] cell_model::cells::script::ScriptError),
    /// The task program of a recorded run cannot be started.
    #[error(
        "the task program of this run, {path}: {source}; build it again, or name another one with `--task PROGRAM`"
    )]
    TaskProgram {
        /// Its path in the recording.
        path: String,
        /// Why.
        source: std::io::Error,
    },
    /// A camera that the cell does not have.
    #[error("--frame-hash: {0}")]
    Camera(#[from] camera::UnknownCamera),
    /// No directory of kept answers.
    #[error("--answers {path}: {source}; --keep-answers writes such a directory", path = path.display())]
    Answers {
        /// The directory.
        path: std::path::PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A rate of actions.
    #[error(transparent)]
    Rate(#[from] action::RateError),
    /// An episode that cannot be recorded.
    #[error("cannot record: {0}")]
    Record(#[from] cell_record::RecordError),
    /// A recording that cannot be verified.
    #[error(transparent)]
    Verify(#[from] verify::VerifyError),
    /// A snapshot that cannot be restored.
    #[error(transparent)]
    Snapshot(#[from] snapshot::SnapshotError),
    /// A checkpoint that the task refuses.
    #[error(transparent)]
    Checkpoint(#[from] robocell_task::CheckpointError),
}
