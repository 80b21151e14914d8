//! Arguments of commands that show cells, their processes and this machine.

use clap::Args;

use crate::args::common::{CellArgs, DataArgs};

/// `robocell list`.
#[derive(Clone, Debug, Args)]
pub struct ListArgs {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}

/// `robocell status` and `robocell doctor`.
#[derive(Clone, Debug, Args)]
pub struct ReportArgs {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell doctor`.
#[derive(Clone, Debug, Args)]
pub struct DoctorArgs {
    /// Run a loop of 1 kHz for ten seconds and judge whether this machine keeps real time
    /// (exit code 3 where it does not)
    #[arg(long)]
    pub measure: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub report: ReportArgs,
}

/// `robocell top`.
#[derive(Clone, Debug, Args)]
#[command(after_help = "In a pipe, one frame is printed as text: `robocell top | cat`.")]
pub struct TopArgs {
    /// Print one snapshot as a JSON object and exit
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell logs`.
#[derive(Clone, Debug, Args)]
pub struct LogsArgs {
    /// Keep printing new lines
    #[arg(short, long)]
    pub follow: bool,
    /// Only this process
    #[arg(value_name = "PROC")]
    pub process: Option<String>,
    /// Print one JSON object per line
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell incident`.
#[derive(Clone, Debug, Args)]
pub struct IncidentArgs {
    /// Number of the incident [default: list all]
    #[arg(value_name = "N")]
    pub number: Option<u32>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}
