//! `robocell assets`.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;

use cell_assets::manifest::Manifest;
use cell_assets::{AssetError, Source, cache, program};
use cell_rt::stdout;
use clap::{Args, Parser, Subcommand};

/// Real meshes of the robots, in place of the built-in look.
#[derive(Debug, Parser)]
#[command(name = "cell-assets", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Download the meshes (131 MB, once), check them, make them small, keep them.
    Fetch {
        #[command(flatten)]
        place: CacheArgs,
        /// Use this file instead of downloading it.
        #[arg(long, value_name = "WHEEL")]
        from: Option<PathBuf>,
        /// Do it again though the meshes are there.
        #[arg(long)]
        force: bool,
    },
    /// What is in the cache.
    List(CacheArgs),
    /// Print the folder of the meshes.
    Path(CacheArgs),
}

#[derive(Debug, Args)]
struct CacheArgs {
    /// Cache to use instead of the user's.
    #[arg(long, value_name = "DIR")]
    cache: Option<PathBuf>,
}

impl CacheArgs {
    fn cache(self) -> Result<PathBuf, AssetError> {
        self.cache
            .or_else(cache::cache_dir)
            .ok_or(AssetError::NoCache)
    }
}

fn main() -> ExitCode {
    program::finish(run(Cli::parse().command))
}

fn run(command: Command) -> Result<(), AssetError> {
    match command {
        Command::Fetch { place, from, force } => {
            let source = from.map_or(Source::Index, Source::Wheel);
            let done = cell_assets::fetch(&place.cache()?, &source, force, &mut program::note)?;
            let already = if done.already { "there already, " } else { "" };
            let (sum, path) = (summary(&done.manifest), done.meshes.display().to_string());
            stdout::line(format_args!("{already}{sum}: {path}"));
        }
        Command::List(place) => {
            let manifest = Manifest::load(&cache::meshes_in(&place.cache()?))?;
            stdout::line(format_args!(
                "{:<8}{:<20}{:>10}{:>10}",
                "robot", "link", "triangles", "bytes"
            ));
            for file in &manifest.files {
                stdout::line(format_args!(
                    "{:<8}{:<20}{:>10}{:>10}",
                    file.robot, file.link, file.triangles, file.bytes
                ));
            }
            stdout::line(summary(&manifest));
        }
        Command::Path(place) => {
            let meshes = cache::meshes_in(&place.cache()?);
            Manifest::load(&meshes)?;
            stdout::line(meshes.display());
        }
    }
    Ok(())
}

fn summary(manifest: &Manifest) -> String {
    let triangles: usize = manifest.files.iter().map(|file| file.triangles).sum();
    let bytes: u64 = manifest.files.iter().map(|file| file.bytes).sum();
    let count = manifest.files.len();
    let (package, version) = (&manifest.package, &manifest.version);
    format!("{count} meshes, {triangles} triangles, {bytes} bytes, from {package} {version}")
}
