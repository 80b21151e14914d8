//! Arguments that many commands have.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use ipc_types::topic::Process;
use supervisor::rundir::DEFAULT_CELL;

use crate::cli_kinds::NameKind;
use crate::cli_values::cell_name;

/// Which cell.
#[derive(Clone, Debug, Args)]
pub struct CellArgs {
    /// Name of the cell
    #[arg(long, value_name = "NAME", default_value = DEFAULT_CELL, value_parser = cell_name)]
    pub cell: String,
}

/// Where cell files and robots are, and what does the task.
#[derive(Clone, Debug, Default, Args)]
pub struct DataArgs {
    /// Directory with `cells/`, and with `robots/` beside the built-in ones
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    /// Task program: a path, or a name beside the cell, beside robocell or on PATH
    /// [default: that of the cell file]
    #[arg(long, value_name = "PROGRAM")]
    pub task: Option<String>,
}

/// `robocell man`.
#[derive(Clone, Debug, Args)]
pub struct ManArgs {
    /// The command, as in `man bt show`
    #[arg(value_name = "COMMAND", conflicts_with = "dir")]
    pub command: Vec<String>,
    /// Write all pages into this directory, as `robocell-COMMAND.1`
    #[arg(long, value_name = "DIR")]
    pub dir: Option<PathBuf>,
}

/// `robocell complete`.
#[derive(Clone, Debug, Args)]
pub struct CompleteArgs {
    /// What to name
    pub kind: NameKind,
    /// The command line so far
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    pub words: Vec<String>,
}

/// A process a person can name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProcessName {
    /// The policy.
    Task,
    /// The controllers of all arms.
    Controller,
    /// The robot and the world.
    Physics,
    /// Page and recorder.
    Monitor,
}

impl ProcessName {
    /// Whether `process` is, or is one of, those of this name.
    pub(crate) fn includes(self, process: Process) -> bool {
        match self {
            Self::Task => process == Process::Task,
            Self::Controller => matches!(process, Process::Controller(_)),
            Self::Physics => process == Process::Physics,
            Self::Monitor => process == Process::Monitor,
        }
    }
}
