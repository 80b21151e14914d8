//! The command line: a contract that scripts depend on. Only what works is here.

use std::path::PathBuf;

use cell_model::runs::spec::Speed;
use clap::{Args, Parser, Subcommand, ValueEnum};
use clap_complete::Shell;

use crate::chaos::FaultKind;
pub use crate::cli_common::{CellArgs, DataArgs};
pub use crate::cli_hand::{GripperArgs, GripperVerb, JointsArgs, TargetArgs};
pub use crate::cli_page::{
    AssetsArgs, AssetsVerb, LoadArgs, RecordArgs, RecordVerb, ReplayArgs, ShotArgs,
};
use crate::cli_values::{
    cell_name, count, finite, host_name, minutes, positive_seconds, rate, seed, seed_range,
};

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
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// One command.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Start a cell and stay with it until it ends or Ctrl-C
    Run(Box<RunArgs>),
    /// List the demos with their policies, and the cells that run
    List(ListArgs),
    /// Say how a running cell is doing (exit code 4 when nothing runs)
    Status(ReportArgs),
    /// Watch a running cell in the terminal
    Top(TopArgs),
    /// Stop a running cell
    Down(CellArgs),
    /// Check this machine and say how to fix what is missing
    Doctor(DoctorArgs),
    /// Print what the processes of a cell wrote
    Logs(LogsArgs),
    /// List the failures that were kept, or print and plot one
    Incident(IncidentArgs),
    /// Put another scene in the place of the one that runs; it waits for `resume`
    Load(LoadArgs),
    /// Keep what the recorder heard
    Record(RecordArgs),
    /// Show a recording on the page, or compute it again and compare
    Replay(ReplayArgs),
    /// Take a picture of the page, without a window
    Shot(ShotArgs),
    /// Fetch the robots' real meshes for the page
    Assets(AssetsArgs),
    /// Stop one process of a running cell and start it again
    Restart(RestartArgs),
    /// Stop simulated time
    Pause(CellArgs),
    /// Let simulated time go on
    Resume(CellArgs),
    /// Run some ticks of 1 ms, then pause
    Step(StepArgs),
    /// Change how fast simulated time passes in a running cell
    Speed(SpeedArgs),
    /// Pause when the task reaches a node, state or guard; list or remove breakpoints
    Break(BreakArgs),
    /// Put the scene back to its beginning
    Reset(CellArgs),
    /// Start, pause, resume or reset the task
    Task(TaskArgs),
    /// Lead the arm: set the target of the tool
    Target(TargetArgs),
    /// Lead the arm: set a joint target
    Joints(JointsArgs),
    /// Open or close the gripper (while the task is paused, or with `reach`)
    Gripper(GripperArgs),
    /// Pull an object to a place by a bounded spring
    Drag(DragArgs),
    /// Drop parts from the dispenser, at any time
    DropParts(DropPartsArgs),
    /// Let the conveyor bring another bin
    AddBin(AddBinArgs),
    /// Show or check a behaviour tree
    Bt(BehaviourArgs),
    /// Show or check a state machine or an event x state matrix
    Fsm(BehaviourArgs),
    /// Print the JSON Schema of a kind of file, for your editor
    Schema(SchemaArgs),
    /// Measure, and print a table or one JSON object
    Bench(BenchArgs),
    /// Run jobs back to back under faults, and count what became of them
    Chaos(ChaosArgs),
    /// Run many seeds in one process and count what became of them
    Eval(EvalArgs),
    /// Make a project of your own: a cell, a policy and a test
    New(NewArgs),
    /// Print completions for a shell
    Completions {
        /// The shell.
        shell: Shell,
    },
    /// Print the manual page
    Man,
}

/// `robocell run`.
#[derive(Clone, Debug, Args)]
#[allow(
    clippy::struct_excessive_bools,
    reason = "each is a flag of the command line"
)]
pub struct RunArgs {
    /// Name of the demo; `robocell list` names them
    pub demo: String,
    /// Policy of the task; the demo's default otherwise
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
    /// Everything in one process, without shared memory
    #[arg(long)]
    pub one_process: bool,
    /// End with the task
    #[arg(long)]
    pub until_done: bool,
    /// End at this simulated time at the latest
    #[arg(long, value_name = "SIM_S", allow_negative_numbers = true, value_parser = positive_seconds)]
    pub timeout: Option<f64>,
    /// Things to do at given times or phases, one JSON object a line
    #[arg(long, value_name = "FILE.jsonl")]
    pub script: Option<PathBuf>,
    /// Keep the whole run in this file (MCAP), whatever the ring forgets
    #[arg(long, value_name = "FILE.mcap", conflicts_with = "one_process")]
    pub record: Option<PathBuf>,
    /// Address (or ADDRESS:PORT) the page listens at; loopback otherwise
    #[arg(long, value_name = "ADDR", conflicts_with = "headless")]
    pub listen: Option<String>,
    /// Name of this machine in links for others, with `--listen`
    #[arg(long, value_name = "NAME", requires = "listen", value_parser = host_name)]
    pub host: Option<String>,
    /// Set the scene up and wait for `robocell resume`
    #[arg(long, conflicts_with = "one_process")]
    pub paused: bool,
    /// Bins the job is about, where it is about bins; all of the cell otherwise
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = count)]
    pub bins: Option<u32>,
    /// Robot to use in place of the demo's
    #[arg(long, value_name = "URDF")]
    pub robot: Option<PathBuf>,
    /// Its collision spheres and limits
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub xrdf: Option<PathBuf>,
    /// Its tuning, a file of `format: rmpflow`
    #[arg(long, value_name = "FILE", requires = "robot")]
    pub rmpflow: Option<PathBuf>,
    /// Print one JSON object when the run has ended
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

/// `robocell chaos`.
#[derive(Clone, Debug, Args)]
pub struct ChaosArgs {
    /// Name of the demo
    pub demo: String,
    /// Policy of the task; the demo's default otherwise
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
    /// Chooses the faults, and the scenes of the jobs from it up
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 0, value_parser = seed)]
    pub seed: u64,
    /// How long
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value = "5", value_parser = minutes)]
    pub minutes: f64,
    /// Name of the cell, so that several run side by side
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
}

/// `robocell new`.
#[derive(Clone, Debug, Args)]
pub struct NewArgs {
    /// Name of the project, its folder and its cell
    pub name: String,
    /// How its task is written; docs/choosing.md compares the six ways
    #[arg(long = "as", value_enum, value_name = "WAY")]
    pub way: Way,
    /// Checkout whose packages a project in Rust is built with; the one this program
    /// was built from otherwise
    #[arg(long, value_name = "DIR")]
    pub crates: Option<PathBuf>,
}

/// `robocell list`.
#[derive(Clone, Debug, Args)]
pub struct ListArgs {
    /// Only the cell of this name
    #[arg(long, value_name = "NAME", value_parser = cell_name)]
    pub cell: Option<String>,
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
    /// Run a loop of 1 kHz for ten seconds, and judge whether this machine keeps time (exit
    /// code 3 where it does not)
    #[arg(long)]
    pub measure: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub report: ReportArgs,
}

/// `robocell top`.
#[derive(Clone, Debug, Args)]
pub struct TopArgs {
    /// Print one frame as text and end
    #[arg(long)]
    pub once: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell logs`.
#[derive(Clone, Debug, Args)]
pub struct LogsArgs {
    /// Go on printing what is added
    #[arg(short, long)]
    pub follow: bool,
    /// Only this process
    #[arg(value_name = "PROC")]
    pub process: Option<String>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell incident`.
#[derive(Clone, Debug, Args)]
pub struct IncidentArgs {
    /// Number of the incident; all are listed otherwise
    #[arg(value_name = "N")]
    pub number: Option<u32>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
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
    /// Window and hands.
    Monitor,
}

/// `robocell restart`.
#[derive(Clone, Debug, Args)]
pub struct RestartArgs {
    /// Which one
    pub process: ProcessName,
    /// Go on with another policy (task only)
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

/// What to do with the task.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TaskVerb {
    /// Give the start event.
    Start,
    /// Pause it: the operator leads.
    Pause,
    /// Let it go on.
    Resume,
    /// Put it back to its beginning.
    Reset,
}

/// `robocell task`.
#[derive(Clone, Debug, Args)]
pub struct TaskArgs {
    /// What to do
    pub verb: TaskVerb,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell drop-parts`.
#[derive(Clone, Debug, Args)]
pub struct DropPartsArgs {
    /// How many; as many as the dispenser drops at a time otherwise
    #[arg(value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=100))]
    pub count: Option<u32>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell add-bin`.
#[derive(Clone, Debug, Args)]
pub struct AddBinArgs {
    /// Upside down; as the seed has it otherwise
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
    /// Where to, metres in the world frame
    #[arg(long, value_names = ["X", "Y", "Z"], num_args = 3, required = true,
          allow_negative_numbers = true, value_parser = finite)]
    pub to: Vec<f64>,
    /// Let go after this many seconds at the latest
    #[arg(long = "for", value_name = "S", allow_negative_numbers = true, default_value_t = 2.0, value_parser = positive_seconds)]
    pub seconds: f64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
}

/// `robocell bt` and `robocell fsm`.
#[derive(Clone, Debug, Args)]
pub struct BehaviourArgs {
    /// What to do with it.
    #[command(subcommand)]
    pub verb: BehaviourVerb,
}

/// What to do with a behaviour.
#[derive(Clone, Debug, Subcommand)]
pub enum BehaviourVerb {
    /// Print it as text, mermaid or dot, or as it runs
    Show(ShowArgs),
    /// Say what in a file is wrong, and what is probably not meant
    Check(CheckArgs),
}

/// `show`.
#[derive(Clone, Debug, Args)]
pub struct ShowArgs {
    /// A demo, or a file; the running cell's policy without
    #[arg(value_name = "DEMO|FILE")]
    pub what: Option<String>,
    /// Policy of the demo; its default otherwise
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// How to print it
    #[arg(long, value_enum, default_value_t = PictureFormat::Text)]
    pub format: PictureFormat,
    /// Print the running cell's policy whenever something in it changes
    #[arg(long, conflicts_with_all = ["what", "policy", "format"])]
    pub live: bool,
    /// With `--live`: only the picture of this arm
    #[arg(long, requires = "live", value_name = "NAME")]
    pub arm: Option<String>,
    /// With `--live`: print once
    #[arg(long, requires = "live")]
    pub once: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub cell: CellArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}

/// `check`.
#[derive(Clone, Debug, Args)]
pub struct CheckArgs {
    /// A tree (JSON), or a machine or matrix (TOML or JSON)
    pub file: PathBuf,
    /// Task program that knows what the file names
    #[arg(long, value_name = "PROGRAM")]
    pub task: Option<String>,
}

/// How a behaviour is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum PictureFormat {
    /// For the terminal
    Text,
    /// For markdown
    Mermaid,
    /// For graphviz
    Dot,
}

impl PictureFormat {
    /// The word on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Text => "text",
            Self::Mermaid => "mermaid",
            Self::Dot => "dot",
        }
    }
}

/// `robocell schema`.
#[derive(Clone, Debug, Args)]
pub struct SchemaArgs {
    /// Which kind of file
    pub what: SchemaKind,
    /// Task program whose jobs are described
    #[arg(long, value_name = "PROGRAM")]
    pub task: Option<String>,
}

/// A kind of file with a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SchemaKind {
    /// Behaviour trees, with the node types of the demos
    Tree,
    /// State machines and matrices
    Machine,
    /// `cells/NAME.toml`
    Cell,
}

impl SchemaKind {
    /// The word on the command line.
    pub fn word(self) -> &'static str {
        match self {
            Self::Tree => "tree",
            Self::Machine => "machine",
            Self::Cell => "cell",
        }
    }
}

/// What to measure.
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
    /// Trees, machines and the task's record
    Behavior,
    /// What the page and the recorder cost
    Monitor,
}

/// `robocell bench`.
#[derive(Clone, Debug, Args)]
pub struct BenchArgs {
    /// What to measure
    pub kind: BenchKind,
    /// Print one JSON object as the last line
    #[arg(long)]
    pub json: bool,
    /// How long `e2e` and `monitor` measure
    #[arg(long, value_name = "S", allow_negative_numbers = true, default_value_t = 5.0, value_parser = positive_seconds)]
    pub seconds: f64,
}

/// `robocell eval`.
#[derive(Clone, Debug, Args)]
pub struct EvalArgs {
    /// Name of the demo
    pub demo: String,
    /// First and last seed, or how many from 0 on
    #[arg(long, value_name = "A..B|N", allow_hyphen_values = true, value_parser = seed_range)]
    pub seeds: (u64, u64),
    /// Policy of the task; the demo's default otherwise
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// Runs at the same time
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub jobs: u32,
    /// Print one JSON object a seed
    #[arg(long)]
    pub json: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}
