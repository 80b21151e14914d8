//! Arguments of `robocell run`.

use std::path::PathBuf;

use cell_model::cells::setting::Setting;
use cell_model::runs::policy_server::Fault;
use clap::Args;

use crate::args::common::{CellArgs, DataArgs, JobArgs, SceneArgs};
use crate::args::page::PageArgs;
use crate::args::robot::{ControllerArgs, RobotArgs};
use crate::args::server::{ServerArgs, latency};

/// `robocell run`.
#[derive(Clone, Debug, Args)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is a flag of the command line"
)]
pub struct RunArgs {
    /// Name of the demo; `robocell list` names them
    pub demo: String,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub scene: SceneArgs,
    /// Start no page
    #[arg(long, conflicts_with = "listen")]
    pub headless: bool,
    /// Run everything in one process, without shared memory
    #[arg(long)]
    pub one_process: bool,
    /// End when the task ends
    #[arg(long)]
    pub until_done: bool,
    /// When the task has ended, play the next seed after 5 s of simulated time
    #[arg(long = "loop", conflicts_with_all = ["until_done", "one_process", "record", "timeout", "json"])]
    pub again: bool,
    /// Open the page in a browser
    #[arg(long, conflicts_with_all = ["headless", "one_process"])]
    pub open: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub job: JobArgs,
    /// Record the whole run to this file (MCAP)
    #[arg(long, value_name = "FILE.mcap", conflicts_with = "one_process")]
    pub record: Option<PathBuf>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub page: PageArgs,
    /// Start paused; `robocell resume` starts it
    #[arg(long, conflicts_with = "one_process")]
    pub paused: bool,
    /// Number in place of that of the cell file, as `task.timeout_s=4`; may be repeated
    #[arg(long, value_name = "KEY=V", value_parser = str::parse::<Setting>)]
    pub set: Vec<Setting>,
    /// Simulated time from an observation to its actions, of a policy behind a socket (ms)
    #[arg(long, value_name = "MS", requires = "policy", value_parser = latency)]
    pub latency_ms: Option<u32>,
    /// Fault of the observations of a policy behind a socket: drop@FROM..TO, late:MS@FROM..TO or
    /// move:CAMERA:X,Y,Z@FROM..TO, in ticks and m
    #[arg(long, value_name = "FAULT", requires = "policy", value_parser = str::parse::<Fault>)]
    pub fault: Option<Fault>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub server: ServerArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub robot: RobotArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub controllers: ControllerArgs,
    /// Print the summary as one JSON object at the end
    #[arg(long)]
    pub json: bool,
    /// Never kill a process that seems to hang (for debuggers)
    #[arg(long)]
    pub no_watchdog: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}
