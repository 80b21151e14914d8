//! Recorded episodes as a `LeRobotDataset` v3.0, and the episodes of a data set computed again
//! from its actions.
//!
//! The format is that of lerobot 0.6: `meta/info.json` names the features, `data` has a row for
//! each frame, `meta/episodes` one for each episode.

mod dataset;
mod episode;
mod features;
mod pictures;
mod replay;
mod stats;
mod table;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use cell_model::Data;
use cell_rt::stdout;
use clap::{Parser, Subcommand};
use parquet::errors::ParquetError;

/// An episode of a data set that differs.
const DIFFERS: u8 = 5;
/// Input that cannot be used.
const CONFIGURATION: u8 = 3;

/// Why no data set is written or computed again.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// A recording.
    #[error(transparent)]
    Record(#[from] cell_record::RecordError),
    /// The run of a recording.
    #[error(transparent)]
    Model(#[from] cell_model::ModelError),
    /// A cell that cannot be computed again.
    #[error(transparent)]
    Sim(#[from] cell_sim::SimError),
    /// A camera.
    #[error("--camera: {0}")]
    Camera(#[from] camera::UnknownCamera),
    /// A recording that does not fit into a data set.
    #[error("{}: {why}", path.display())]
    Episode {
        /// The recording.
        path: PathBuf,
        /// Reason.
        why: String,
    },
    /// A file.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of Parquet.
    #[error("{}: {source}", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ParquetError,
    },
}

impl ExportError {
    fn io(path: &Path, source: std::io::Error) -> Self {
        let path = path.to_owned();
        Self::Io { path, source }
    }

    fn table(path: &Path, source: ParquetError) -> Self {
        let path = path.to_owned();
        Self::Table { path, source }
    }

    fn episode(path: &Path, why: impl Into<String>) -> Self {
        let (path, why) = (path.to_owned(), why.into());
        Self::Episode { path, why }
    }
}

#[derive(Parser)]
#[command(name = "robocell-export")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Write a data set.
    Lerobot {
        /// Its directory.
        out: PathBuf,
        /// Recordings.
        files: Vec<PathBuf>,
        /// Cameras.
        #[arg(long)]
        camera: Vec<String>,
    },
    /// Compute the episodes of a data set again.
    Replay {
        /// Its directory.
        dir: PathBuf,
    },
}

/// The program.
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Lerobot { out, files, camera } => lerobot(&out, &files, &camera),
        Command::Replay { dir } => replay::run(&data(), &dir).map(|differs| {
            if differs {
                ExitCode::from(DIFFERS)
            } else {
                ExitCode::SUCCESS
            }
        }),
    };
    let code = done.unwrap_or_else(|error| {
        // Where stderr cannot be written, no channel is left for a report.
        writeln!(std::io::stderr(), "robocell: {error}").ok();
        ExitCode::from(CONFIGURATION)
    });
    // A script would take a truncated output for the whole one, so a failed write is an error even
    // where the work was done.
    match stdout::finish() {
        Ok(()) => code,
        Err(error) => {
            writeln!(
                std::io::stderr(),
                "robocell: cannot write to standard output: {error}"
            )
            .ok();
            ExitCode::from(CONFIGURATION)
        }
    }
}

fn data() -> Data {
    cell_files::data()
}

fn lerobot(out: &Path, files: &[PathBuf], cameras: &[String]) -> Result<ExitCode, ExportError> {
    let written = export(&data(), out, files, cameras)?;
    stdout::line(format_args!("{}: {written}", out.display()));
    Ok(ExitCode::SUCCESS)
}

/// Writes a data set of recordings, in their order; a sentence about it.
///
/// # Errors
/// For a recording that does not fit, an unknown camera, and a file that cannot be written.
pub fn export(
    data: &Data,
    out: &Path,
    files: &[PathBuf],
    cameras: &[String],
) -> Result<String, ExportError> {
    dataset::write(data, out, files, cameras)
}

/// Computes the episodes of a data set again and prints the result; whether one differs.
///
/// # Errors
/// For a data set that cannot be read and a cell that cannot be set up.
pub fn replay(data: &Data, dir: &Path) -> Result<bool, ExportError> {
    replay::run(data, dir)
}
