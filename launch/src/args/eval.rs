//! Arguments of `robocell eval`.

use std::path::PathBuf;

use cell_model::cells::sweep::{Bounds, Values};
use cell_model::runs::policy_server::Fault;
use clap::{Args, Subcommand};
use evaluation::shard::Shard;

use crate::args::common::{DataArgs, JobArgs};
use crate::args::robot::RobotArgs;
use crate::args::server::{ServerArgs, latency};
use crate::args::values::{count, seed_range, share};

/// `robocell eval`.
#[derive(Clone, Debug, Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub struct EvalArgs {
    /// Action on existing rows
    #[command(subcommand)]
    pub verb: Option<EvalVerb>,
    /// Name of the demo
    #[arg(required = true)]
    pub demo: Option<String>,
    /// First and last seed, or a count of seeds from 0
    #[arg(long, value_name = "A..B|N", required = true, allow_hyphen_values = true, value_parser = seed_range)]
    pub seeds: Option<(u64, u64)>,
    /// Run part I of N of the seeds, from 1/N to N/N
    #[arg(long, value_name = "I/N", requires = "out", default_value = "1/1", value_parser = str::parse::<Shard>)]
    pub shard: Shard,
    /// Append a row for each seed to this file; repeat the command after a stop to resume
    #[arg(long, value_name = "FILE.jsonl")]
    pub out: Option<PathBuf>,
    /// Record each episode that does not end done to this directory, by running it once more
    #[arg(long, value_name = "DIR", requires = "out", conflicts_with = "rate")]
    pub record_failures: Option<PathBuf>,
    /// Hold each action of the task for the period of this rate, in numbers of 32 bits, as a
    /// learned policy acts (Hz)
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = count)]
    pub rate: Option<u32>,
    /// Record the decisions of each episode, and a state for each action, to this directory
    #[arg(long, value_name = "DIR", requires = "rate")]
    pub record: Option<PathBuf>,
    /// Write hashes of colour, depth and mask of the last picture of this camera into the row;
    /// may be repeated
    #[arg(long, value_name = "CAMERA")]
    pub frame_hash: Vec<String>,
    /// Simulated time from an observation to its actions, of a policy behind a socket; of several
    /// each is run with every seed (ms)
    #[arg(long, value_name = "MS[,MS..]", value_delimiter = ',', requires = "policy", value_parser = latency)]
    pub latency_ms: Vec<u32>,
    /// Fault of the observations of a policy behind a socket: drop@FROM..TO, late:MS@FROM..TO or
    /// move:CAMERA:X,Y,Z@FROM..TO, in ticks and m; each is run with every seed, as is none
    #[arg(long, value_name = "FAULT", requires = "policy", value_parser = str::parse::<Fault>)]
    pub fault: Vec<Fault>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub server: ServerArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub episodes: EpisodeArgs,
    /// Print one JSON object per seed, and one for all seeds as the last line; with `--out`
    /// the last line alone
    #[arg(long)]
    pub json: bool,
}

/// The options of every episode.
#[derive(Clone, Debug, Args)]
pub struct EpisodeArgs {
    /// Policy of the task, or the WebSocket address of a policy server [default: that of the demo]
    #[arg(long, value_name = "P")]
    pub policy: Option<String>,
    /// Runs at the same time
    #[arg(long, value_name = "N", allow_negative_numbers = true, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=256))]
    pub jobs: u32,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub job: JobArgs,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub robot: RobotArgs,
    /// Number in place of that of the cell file; of several values each is run with every seed
    #[arg(long, value_name = "KEY=V[,V..]", value_parser = str::parse::<Values>)]
    pub set: Vec<Values>,
    /// Number in place of that of the cell file, drawn between both bounds for every seed
    #[arg(long, value_name = "KEY=LOW..HIGH", value_parser = str::parse::<Bounds>)]
    pub vary: Vec<Bounds>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "flattened: help text would be shown twice")]
    pub data: DataArgs,
}

/// Actions on existing rows.
#[derive(Clone, Debug, Subcommand)]
pub enum EvalVerb {
    /// Print the rows of all shards in the order of their seeds
    Merge(MergeArgs),
    /// Report success, reasons and times of rows; compare two files by their seeds
    Report(ReportRowsArgs),
}

/// `robocell eval report`.
#[derive(Clone, Debug, Args)]
pub struct ReportRowsArgs {
    /// File of rows
    #[arg(value_name = "FILE.jsonl")]
    pub file: PathBuf,
    /// File of rows to compare with the first
    #[arg(value_name = "FILE2.jsonl")]
    pub other: Option<PathBuf>,
    /// End with 7 where the second file is done less often, with 3 where too few episodes are in both
    #[arg(long, requires = "other")]
    pub gate: bool,
    /// Least loss of success that the gate has to see (share of the episodes)
    #[arg(long, value_name = "SHARE", requires = "gate", default_value = "0.05", allow_negative_numbers = true, value_parser = share)]
    pub loss: f64,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
    /// Write a page with plots, and the command that runs each failed seed again
    #[arg(long, value_name = "FILE.html")]
    pub html: Option<PathBuf>,
}

/// `robocell eval merge`.
#[derive(Clone, Debug, Args)]
pub struct MergeArgs {
    /// Files of rows, one of each shard
    #[arg(required = true, value_name = "FILE.jsonl")]
    pub files: Vec<PathBuf>,
}
