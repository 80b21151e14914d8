//! The command line of the page and of recordings.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use crate::args::common::{CellArgs, DataArgs, SceneArgs};
use crate::args::values::{host_name, seconds, seconds_back};

/// Where the page is served.
#[derive(Clone, Debug, Args)]
pub struct PageArgs {
    /// Address (or ADDRESS:PORT) the page listens at [default: loopback]
    #[arg(long, value_name = "ADDR")]
    pub listen: Option<String>,
    /// Name of this machine in links for others, with `--listen`
    #[arg(long, value_name = "NAME", requires = "listen", value_parser = host_name)]
    pub host: Option<String>,
}

/// `robocell load`.
#[derive(Clone, Debug, Args)]
pub struct LoadArgs {
    /// Name of the demo; `robocell list` names them
    pub demo: String,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub scene: SceneArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell record`.
#[derive(Clone, Debug, Args)]
pub struct RecordArgs {
    /// Action
    #[command(subcommand)]
    pub verb: RecordVerb,
    /// Print one JSON object
    #[arg(long, global = true)]
    pub json: bool,
}

/// Actions of the recorder.
#[derive(Clone, Debug, Subcommand)]
pub enum RecordVerb {
    /// Save everything from now on
    Start {
        /// File to write (MCAP) [default: DEMO.mcap, or the next free DEMO-N.mcap]
        #[arg(value_name = "FILE.mcap")]
        file: Option<PathBuf>,
        #[command(flatten)]
        #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
        cell: CellArgs,
    },
    /// Close the file of `start` or `run --record`
    Stop(CellArgs),
    /// Save the last seconds of the flight recorder, as in `last 60s`
    Last {
        /// How far back
        #[arg(value_name = "60s", allow_hyphen_values = true, value_parser = seconds_back)]
        span: f64,
        /// File to write (MCAP) [default: DEMO.mcap, or the next free DEMO-N.mcap]
        #[arg(value_name = "FILE.mcap")]
        file: Option<PathBuf>,
        #[command(flatten)]
        #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
        cell: CellArgs,
    },
}

impl RecordVerb {
    /// The cell whose recorder is asked.
    pub(crate) fn cell(&self) -> &str {
        match self {
            Self::Start { cell, .. } | Self::Stop(cell) | Self::Last { cell, .. } => &cell.cell,
        }
    }
}

/// `robocell plot`.
#[derive(Clone, Debug, Args)]
#[command(after_help = "Signals have the names of the plots of the page, as in \
`robocell plot what-happened.mcap \"panda/joint1 position\" \"panda/* error\"`.")]
pub struct PlotArgs {
    /// The recording (MCAP), or the directory of a flight recorder
    pub file: PathBuf,
    /// Names of signals; `*` matches any text. Without one, the signals are listed
    #[arg(value_name = "SIGNAL")]
    pub signals: Vec<String>,
    /// First simulated time (s) [default: that of the recording]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = seconds)]
    pub from: Option<f64>,
    /// Last simulated time (s) [default: that of the recording]
    #[arg(long, value_name = "S", allow_negative_numbers = true, value_parser = seconds)]
    pub to: Option<f64>,
    /// Write a picture (SVG) in place of charts of characters
    #[arg(long, value_name = "FILE.svg", conflicts_with = "json")]
    pub output: Option<PathBuf>,
    /// Print the samples as one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `robocell assets`.
#[derive(Clone, Debug, Args)]
pub struct AssetsArgs {
    /// Action
    #[command(subcommand)]
    pub verb: AssetsVerb,
}

/// Actions on the meshes.
#[derive(Clone, Debug, Subcommand)]
pub enum AssetsVerb {
    /// Fetch them from the Python package index, check them and make them small
    Fetch {
        /// Use this package instead of the index
        #[arg(long, value_name = "WHEEL")]
        from: Option<PathBuf>,
        /// Fetch them even if they are present
        #[arg(long)]
        force: bool,
    },
    /// List the fetched meshes
    List,
}

/// `robocell export`.
#[derive(Clone, Debug, Args)]
pub struct ExportArgs {
    /// New directory for a data set in the format of lerobot (version 3.0)
    #[arg(long, value_name = "DIR")]
    pub lerobot: PathBuf,
    /// Recordings of `robocell eval --rate HZ --record DIR`, an episode each
    #[arg(required = true, value_name = "FILE.mcap")]
    pub files: Vec<PathBuf>,
    /// Camera whose pictures the data set has; may be repeated
    #[arg(long, value_name = "NAME")]
    pub camera: Vec<String>,
}

/// `robocell replay`.
#[derive(Clone, Debug, Args)]
pub struct ReplayArgs {
    /// The recording (MCAP), or the directory of a flight recorder, or of a data set
    pub file: PathBuf,
    /// Recompute every command and decision and compare bit for bit
    #[arg(long, conflicts_with = "listen")]
    pub verify: bool,
    /// Recompute the episodes of a data set from its actions alone and compare bit for bit
    #[arg(long, conflicts_with_all = ["verify", "listen"])]
    pub actions: bool,
    /// With `--verify`: print one JSON object
    #[arg(long, requires = "verify")]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub page: PageArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}
