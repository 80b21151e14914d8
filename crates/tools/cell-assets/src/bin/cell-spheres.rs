//! `robocell spheres`.
#![forbid(unsafe_code)]

use std::path::PathBuf;
use std::process::ExitCode;

use cell_assets::program;
use cell_assets::spheres::{Packages, Rules, SphereError, fit_robot};
use cell_model::RobotFiles;
use cell_rt::stdout;
use clap::Parser;

/// Fits collision spheres to the geometry of a URDF and prints an XRDF.
#[derive(Debug, Parser)]
#[command(name = "cell-spheres", version)]
struct Cli {
    urdf: PathBuf,
    #[arg(long)]
    tip: Option<String>,
    #[arg(long)]
    margin: f64,
    #[arg(long)]
    most: usize,
    #[arg(long)]
    package: Vec<String>,
}

fn main() -> ExitCode {
    program::finish(run(Cli::parse()))
}

fn run(cli: Cli) -> Result<(), SphereError> {
    // The launcher checked them.
    let named = cli.package.iter().filter_map(|text| text.split_once('='));
    let named = named.map(|(name, dir)| (name.to_owned(), PathBuf::from(dir)));
    let packages = Packages::from_environment(named.collect());
    let files = RobotFiles {
        urdf: cli.urdf,
        tip: cli.tip,
        ..RobotFiles::default()
    };
    // A `config.json` names an XRDF as well, which the new one replaces.
    let files = RobotFiles {
        xrdf: None,
        rmpflow: None,
        ..files.resolved()?
    };
    let rules = Rules {
        margin: cli.margin,
        most: cli.most,
    };
    let fitted = fit_robot(&files, &packages, rules)?;
    for link in &fitted.links {
        let (count, out) = (link.fit.spheres.len(), 1000.0 * link.fit.margin);
        let from = if link.is_visual {
            " (of its visual)"
        } else {
            ""
        };
        let name = &link.name;
        program::note(&format!(
            "{name}: {count} spheres, at most {out:.0} mm out of it{from}"
        ));
    }
    stdout::line(fitted.xrdf.trim_end());
    Ok(())
}
