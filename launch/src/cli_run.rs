//! Arguments of `robocell run`.

use std::path::PathBuf;

use cell_model::cells::setting::Setting;
use cell_model::runs::spec::Speed;
use clap::Args;

use crate::cli_common::{CellArgs, DataArgs};
use crate::cli_robot::RobotArgs;
use crate::cli_values::{count, host_name, positive_seconds, seed};

/// `robocell run`.
#[derive(Clone, Debug, Args)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is a flag of the command line"
)]
pub struct RunArgs {
    /// Name of the demo; `robocell list` names them
    pub demo: String,
    /// Policy of the task [default: that of the demo]
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// Varies poses and friction within the bounds of the cell file
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0, value_parser = seed)]
    pub seed: u64,
    /// `1`: real time; `max` or another factor: lockstep
    #[arg(long, value_name = "1|max|X", allow_negative_numbers = true, default_value = "1", value_parser = str::parse::<Speed>)]
    pub speed: Speed,
    /// Start no page
    #[arg(long)]
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
    /// Describe the arms: joints, tool frame, collision spheres and tuning
    #[arg(short, long)]
    pub verbose: bool,
    /// End at this simulated time at the latest (s)
    #[arg(long, value_name = "SIM_S", allow_negative_numbers = true, value_parser = positive_seconds)]
    pub timeout: Option<f64>,
    /// Script: what to do at which time or phase, one JSON object per line
    #[arg(long, value_name = "FILE.jsonl")]
    pub script: Option<PathBuf>,
    /// Record the whole run to this file (MCAP)
    #[arg(long, value_name = "FILE.mcap", conflicts_with = "one_process")]
    pub record: Option<PathBuf>,
    /// Address (or ADDRESS:PORT) the page listens at [default: loopback]
    #[arg(long, value_name = "ADDR", conflicts_with = "headless")]
    pub listen: Option<String>,
    /// Name of this machine in links for others, with `--listen`
    #[arg(long, value_name = "NAME", requires = "listen", value_parser = host_name)]
    pub host: Option<String>,
    /// Start paused; `robocell resume` starts it
    #[arg(long, conflicts_with = "one_process")]
    pub paused: bool,
    /// Number of bins of the job [default: all bins of the cell]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub bins: Option<u32>,
    /// Number in place of that of the cell file, as `task.timeout_s=4`; may be repeated
    #[arg(long, value_name = "KEY=V", value_parser = str::parse::<Setting>)]
    pub set: Vec<Setting>,
    /// Answer of a leaf that is not run, as NODE=success, NODE=failure or NODE=running, each
    /// with :SECONDS for a time; or a file with one rule a line; may be repeated
    #[arg(long, value_name = "NODE=RESULT|FILE.jsonl")]
    pub replace: Vec<String>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub robot: RobotArgs,
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
