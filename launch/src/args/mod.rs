//! The command line: a contract that scripts depend on. It has only options that work.

mod behaviour;
mod camera;
mod common;
mod eval;
mod hand;
pub(crate) mod kinds;
mod operate;
mod page;
mod robot;
mod run;
pub(crate) mod server;
mod status;
mod values;

use std::path::PathBuf;

use cell_run::spec::Speed;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

pub use behaviour::{
    BehaviourArgs, BehaviourVerb, CheckArgs, ImportArgs, PictureFormat, SchemaArgs, SchemaKind,
    ShowArgs, TreeArgs, TreeVerb,
};
pub use camera::CameraArgs;
pub use common::{
    CellArgs, CompleteArgs, DataArgs, JobArgs, ManArgs, ProcessName, ProgramArgs, SceneArgs,
};
pub use eval::{EpisodeArgs, EvalArgs, EvalVerb, MergeArgs, ReportRowsArgs};
pub use hand::{ArmArgs, GraspArgs, GripperArgs, GripperVerb, JointsArgs, MoveArgs, TargetArgs};
use kinds::FaultKind;
pub use operate::{
    AddBinArgs, BreakArgs, DragArgs, DropPartsArgs, RestartArgs, SpeedArgs, StepArgs, TaskArgs,
    TaskVerb,
};
pub use page::{
    AssetsArgs, AssetsVerb, ExportArgs, LoadArgs, PageArgs, PlotArgs, RecordArgs, RecordVerb,
    ReplayArgs,
};
pub use robot::{ControllerArgs, ControllerOf, RobotArgs, SpheresArgs};
pub use run::RunArgs;
pub use status::{DoctorArgs, IncidentArgs, ListArgs, LogsArgs, ReportArgs, TopArgs};
use values::{cell_name, count, minutes, positive_seconds, rate, seed};

/// Runs simulated robot cells.
#[derive(Debug, Parser)]
#[command(
    name = "robocell",
    version,
    about,
    max_term_width = 100,
    propagate_version = true
)]
#[command(
    after_help = "Exit codes: 0 done, 2 usage, 3 configuration or already running, 4 not running, \
5 the task failed or timed out, or a recording differs, 6 a process gave up."
)]
pub struct Cli {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

/// One command.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a cell until it ends or Ctrl-C is pressed
    Run(Box<RunArgs>),
    /// List the demos with their policies, and the running cells
    List(ListArgs),
    /// Show the status of a running cell
    Status(ReportArgs),
    /// Watch a running cell in the terminal
    Top(TopArgs),
    /// Stop a running cell
    Down(CellArgs),
    /// Check this machine: print each lack with its effect and its fix
    Doctor(DoctorArgs),
    /// Print the logs of the processes of a cell
    Logs(LogsArgs),
    /// List the kept failures of a cell, or print and plot one
    Incident(IncidentArgs),
    /// Replace the running scene; the new one starts paused
    Load(LoadArgs),
    /// Save recorded data to a file
    Record(RecordArgs),
    /// Plot signals of a recording over time
    Plot(PlotArgs),
    /// Show a recording on the page, or recompute it and compare
    Replay(ReplayArgs),
    /// Write recorded episodes as a data set for robot learning
    Export(ExportArgs),
    /// Draw what the cameras of a cell see at a time of a run
    Camera(CameraArgs),
    /// Fetch the meshes of the robots for the page
    Assets(AssetsArgs),
    /// Fit collision spheres to the meshes of a URDF and print an XRDF
    Spheres(SpheresArgs),
    /// Restart one process of a running cell
    Restart(RestartArgs),
    /// Pause simulated time
    Pause(CellArgs),
    /// Resume simulated time
    Resume(CellArgs),
    /// Run a number of ticks of 1 ms, then pause
    Step(StepArgs),
    /// Change the speed of simulated time in a running cell
    Speed(SpeedArgs),
    /// Set, list or remove breakpoints on nodes, states and guards of the task
    Break(BreakArgs),
    /// Reset the scene to its start
    Reset(CellArgs),
    /// Start, pause, resume or reset the task
    Task(TaskArgs),
    /// Set the target of the tool (while the task is paused, or with `reach`)
    Target(TargetArgs),
    /// Set a joint target (while the task is paused, or with `reach`)
    Joints(JointsArgs),
    /// Open or close the gripper (while the task is paused, or with `reach`)
    Gripper(GripperArgs),
    /// Show the grasps of an object, and what excludes the others
    Grasp(GraspArgs),
    /// Drag an object to a position with a spring of bounded force
    Drag(DragArgs),
    /// Drop parts from the dispenser
    DropParts(DropPartsArgs),
    /// Have the conveyor bring another bin
    AddBin(AddBinArgs),
    /// Show, check or import a behaviour tree
    Bt(TreeArgs),
    /// Show or check a state machine or an event x state matrix
    Fsm(BehaviourArgs),
    /// Print the JSON Schema of a kind of file, or of an output
    Schema(SchemaArgs),
    /// Measure, and print a table or one JSON object
    Bench(BenchArgs),
    /// Run jobs one after the other under injected faults and count the results
    Chaos(ChaosArgs),
    /// Run many seeds, on one machine or in shards on many, and count the results
    Eval(Box<EvalArgs>),
    /// Create a project: a cell, a policy and a test
    New(NewArgs),
    /// Print completions for a shell
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Print the names a shell completes
    #[command(hide = true)]
    Complete(CompleteArgs),
    /// Print the manual page of robocell or of a command, or write all pages to files
    Man(ManArgs),
}

/// `robocell chaos`.
#[derive(Clone, Debug, Args)]
pub struct ChaosArgs {
    /// Name of the demo
    pub demo: String,
    /// Policy of the task [default: that of the demo]
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// Faults a minute, on average
    #[arg(long, value_name = "R", allow_negative_numbers = true, default_value = "6", value_parser = rate)]
    pub rate: f64,
    /// Kinds of faults
    #[arg(
        long,
        value_name = "KINDS",
        value_delimiter = ',',
        default_value = "kill,stop,starve,flood,fill,corrupt"
    )]
    pub faults: Vec<FaultKind>,
    /// So many kills at random instants of the whole job, instead of faults for so many
    /// minutes; the job is repeated until all are done
    #[arg(long, value_name = "N", allow_negative_numbers = true, conflicts_with_all = ["rate", "faults", "minutes"], value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub kills: Option<u32>,
    /// Kill and stop no other process
    #[arg(long, value_name = "PROCESS")]
    pub process: Option<ProcessName>,
    /// Script that each job plays beside the faults: actions by time or phase, one JSON object
    /// per line, as those that the drill writes
    #[arg(long, value_name = "FILE.jsonl")]
    pub script: Option<PathBuf>,
    /// Seed of the faults and of the first scene
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0, value_parser = seed)]
    pub seed: u64,
    /// Duration (min)
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value = "5", value_parser = minutes)]
    pub minutes: f64,
    /// `1`: real time; `max` or another factor: lockstep
    #[arg(long, value_name = "1|max|X", allow_negative_numbers = true, default_value = "1", value_parser = str::parse::<Speed>)]
    pub speed: Speed,
    /// Number of bins of the job [default: all bins of the cell]
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub bins: Option<u32>,
    /// Name of the cell
    #[arg(long, value_name = "NAME", default_value = "chaos", value_parser = cell_name)]
    pub cell: String,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}

/// How the task of a project is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Way {
    /// One if/else, in Rust
    Ifelse,
    /// A state machine without a library, in Rust
    Fsm,
    /// A behaviour tree in Rust
    Tree,
    /// A behaviour tree in a JSON file
    Json,
    /// A table of states and transitions, in a TOML file
    Table,
    /// An event x state matrix, in a TOML file
    Matrix,
    /// A class in a Python file
    Python,
}

/// `robocell new`.
#[derive(Clone, Debug, Args)]
pub struct NewArgs {
    /// Name of the project, its folder and its cell
    pub name: String,
    /// How its task is written; docs/choosing.md compares six of the ways
    #[arg(long = "as", value_enum, value_name = "WAY")]
    pub way: Way,
    /// Checkout whose packages a project in Rust is built with [default: that of this program]
    #[arg(long, value_name = "DIR")]
    pub crates: Option<PathBuf>,
}

/// Kinds of measurement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BenchKind {
    /// Round trips between two processes
    Ipc,
    /// Lateness of the 1 kHz loop
    Loop,
    /// Age of the state when its command is applied
    E2e,
    /// The controller's tick
    Control,
    /// The physics step
    Physics,
    /// Pictures of the cameras of two demos
    Camera,
    /// Cells per core, memory of a cell, start of an episode, cost over size
    Fleet,
}

/// `robocell bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// Kind of measurement
    pub kind: BenchKind,
    /// Print one JSON object as the last line
    #[arg(long)]
    pub json: bool,
    /// How long `e2e` and each part of `fleet` measure (s)
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value_t = 5.0, value_parser = positive_seconds)]
    pub seconds: f64,
}
