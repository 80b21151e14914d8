//! Arguments of `robocell camera`.

use std::path::PathBuf;

use cell_model::cells::setting::Setting;
use cell_run::spec::Speed;
use clap::Args;
use supervisor::rundir::DEFAULT_CELL;

use crate::args::common::{CellArgs, DataArgs, JobArgs, SceneArgs};
use crate::args::page::PageArgs;
use crate::args::robot::{ControllerArgs, RobotArgs};
use crate::args::run::RunArgs;
use crate::args::server::ServerArgs;
use crate::args::values::{seconds, seed};

/// `robocell camera`.
#[derive(Clone, Debug, Args)]
pub struct CameraArgs {
    /// Name of the demo
    pub demo: String,
    /// Camera of the cell file; may be repeated
    #[arg(long, value_name = "NAME", default_value = "front")]
    pub camera: Vec<String>,
    /// Simulated time of the pictures (s)
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value = "0", value_parser = seconds)]
    pub time: f64,
    /// Varies poses and friction within the bounds of the cell file
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0, value_parser = seed)]
    pub seed: u64,
    /// Policy of the task [default: that of the demo]
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// Print the hashes of colour, depth and mask
    #[arg(long, required_unless_present = "out")]
    pub hash: bool,
    /// Write NAME.png, NAME.depth.png (mm) and NAME.mask.png of each camera to this directory
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Number in place of that of the cell file, as `task.timeout_s=4`; may be repeated
    #[arg(long, value_name = "KEY=V", value_parser = str::parse::<Setting>)]
    pub set: Vec<Setting>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub robot: RobotArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}

impl CameraArgs {
    /// The run up to the time of the pictures.
    pub(crate) fn as_run(&self) -> RunArgs {
        RunArgs {
            demo: self.demo.clone(),
            scene: SceneArgs {
                policy: self.policy.clone(),
                seed: self.seed,
                speed: Speed::Max,
            },
            headless: true,
            one_process: true,
            until_done: false,
            again: false,
            open: false,
            job: JobArgs {
                timeout: None,
                script: None,
                bins: None,
                replace: Vec::new(),
            },
            record: None,
            page: PageArgs {
                listen: None,
                host: None,
            },
            paused: false,
            set: self.set.clone(),
            latency_ms: None,
            fault: None,
            server: ServerArgs::default(),
            robot: self.robot.clone(),
            controllers: ControllerArgs::default(),
            json: false,
            no_watchdog: false,
            cell: CellArgs {
                cell: DEFAULT_CELL.to_owned(),
            },
            data: self.data.clone(),
        }
    }
}
