//! Arguments of commands that an operator gives to a running cell.

use cell_run::spec::Speed;
use clap::{Args, ValueEnum};

use crate::args::common::{CellArgs, ProcessName};
use crate::args::values::{finite, positive_seconds};

/// `robocell restart`.
#[derive(Clone, Debug, Args)]
pub struct RestartArgs {
    /// Which one
    pub process: ProcessName,
    /// Restart with another policy (task only)
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell step`.
#[derive(Clone, Debug, Args)]
pub struct StepArgs {
    /// Ticks of 1 ms
    #[arg(default_value_t = 1, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub ticks: u32,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell speed`.
#[derive(Clone, Debug, Args)]
pub struct SpeedArgs {
    /// `1`: real time; `max` or another factor: lockstep
    #[arg(value_name = "1|max|X", allow_negative_numbers = true, value_parser = str::parse::<Speed>)]
    pub speed: Speed,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell break`.
#[derive(Clone, Debug, Args)]
pub struct BreakArgs {
    /// Name of a node, state or guard of the task; all breakpoints are listed otherwise
    pub name: Option<String>,
    /// Remove the breakpoint
    #[arg(long, requires = "name")]
    pub remove: bool,
    /// Print one JSON object
    #[arg(long, conflicts_with = "name")]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// Actions on the task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TaskVerb {
    /// Give the start event; in a pause it takes effect at resume.
    Start,
    /// Pause it: the operator leads.
    Pause,
    /// Resume it.
    Resume,
    /// Open the gripper, send the arm to its default pose, and pause at the beginning.
    Reset,
}

/// `robocell task`.
#[derive(Clone, Debug, Args)]
pub struct TaskArgs {
    /// Action
    pub verb: TaskVerb,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell drop-parts`.
#[derive(Clone, Debug, Args)]
pub struct DropPartsArgs {
    /// How many [default: as many as the dispenser drops at a time]
    #[arg(value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub count: Option<u32>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell add-bin`.
#[derive(Clone, Debug, Args)]
pub struct AddBinArgs {
    /// Upside down [default: decided by the seed]
    #[arg(long)]
    pub flipped: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell drag`.
#[derive(Clone, Debug, Args)]
pub struct DragArgs {
    /// Name of the object in the cell file
    pub object: String,
    /// Position to drag it to (m, world frame)
    #[arg(long, value_names = ["X", "Y", "Z"], num_args = 3, required = true,
          allow_negative_numbers = true, value_parser = finite)]
    pub to: Vec<f64>,
    /// Release it after this time at the latest (s)
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, default_value_t = 2.0, value_parser = positive_seconds)]
    pub seconds: f64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}
