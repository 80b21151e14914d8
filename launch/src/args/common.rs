//! Arguments that many commands have.

use std::path::PathBuf;

use cell_run::spec::Speed;
use clap::{Args, ValueEnum};
use ipc_types::topic::Process;
use supervisor::rundir::DEFAULT_CELL;

use crate::args::kinds::NameKind;
use crate::args::values::{cell_name, count, positive_seconds, seed};

/// Which cell.
#[derive(Clone, Debug, Args)]
pub struct CellArgs {
    /// Name of the cell
    #[arg(long, value_name = "NAME", default_value = DEFAULT_CELL, value_parser = cell_name)]
    pub cell: String,
}

/// A task program.
#[derive(Clone, Debug, Default, Args)]
pub struct ProgramArgs {
    /// Task program: a path, or a name beside the cell, beside robocell or on PATH
    /// [default: that of the cell file]
    #[arg(long, value_name = "PROGRAM")]
    pub task: Option<String>,
}

/// Where cell files and robots are, and the task program.
#[derive(Clone, Debug, Default, Args)]
pub struct DataArgs {
    /// Directory with `cells/`, and with `robots/` beside the built-in ones
    #[arg(long, value_name = "DIR")]
    pub data: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub program: ProgramArgs,
}

/// A scene, its policy and its pace.
#[derive(Clone, Debug, Args)]
pub struct SceneArgs {
    /// Policy of the task, or the WebSocket address of a policy server [default: that of the demo]
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// Varies poses and friction within the bounds of the cell file
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0, value_parser = seed)]
    pub seed: u64,
    /// `1`: real time; `max` or another factor: lockstep
    #[arg(long, value_name = "1|max|X", allow_negative_numbers = true, default_value = "1", value_parser = str::parse::<Speed>)]
    pub speed: Speed,
}

/// The job of a run and its disturbances.
#[derive(Clone, Debug, Args)]
pub struct JobArgs {
    /// End at this simulated time at the latest (s)
    #[arg(long, value_name = "SIM_S", allow_negative_numbers = true, value_parser = positive_seconds)]
    pub timeout: Option<f64>,
    /// Script: actions by time or phase, one JSON object per line
    #[arg(long, value_name = "FILE.jsonl")]
    pub script: Option<PathBuf>,
    /// Number of bins of the job [default: all bins of the cell]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub bins: Option<u32>,
    /// Answer of a leaf that is not run, as NODE=success, NODE=failure or NODE=running, each
    /// with :SECONDS for a time; or a file with one rule a line; may be repeated
    #[arg(long, value_name = "NODE=RESULT|FILE.jsonl")]
    pub replace: Vec<String>,
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
    /// Kind of name
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
    /// Its word on the command line.
    pub(crate) fn word(self) -> &'static str {
        match self {
            Self::Task => "task",
            Self::Controller => "controller",
            Self::Physics => "physics",
            Self::Monitor => "monitor",
        }
    }

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
