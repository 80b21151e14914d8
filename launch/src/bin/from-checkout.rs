//! `cargo robocell ...` in a checkout: builds every program of the cell once,
//! then becomes `robocell` with the same arguments. `robocell` itself never
//! calls cargo.

use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::Path;
use std::process::{Command, ExitCode};

/// Packages whose programs a cell needs.
const PACKAGES: [&str; 6] = [
    "launch",
    "physics-proc",
    "controller-proc",
    "task-proc",
    "monitor-proc",
    "cell-sim",
];

fn main() -> ExitCode {
    match build_and_become() {
        Ok(code) => code,
        Err(message) => {
            writeln!(std::io::stderr(), "robocell: {message}").ok();
            ExitCode::from(3)
        }
    }
}

fn build_and_become() -> Result<ExitCode, String> {
    let own = std::env::current_exe().map_err(|error| error.to_string())?;
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name("Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo);
    build
        .args(["build", "--release", "--bins", "--manifest-path"])
        .arg(&manifest);
    // The first build takes minutes and has to be seen; later ones only wait.
    if own.with_file_name("cell-sim").is_file() {
        build.arg("--quiet");
    }
    for package in PACKAGES {
        build.args(["--package", package]);
    }
    let status = build
        .status()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    if !status.success() {
        return Ok(ExitCode::from(3));
    }
    let robocell = own.with_file_name("robocell");
    let error = Command::new(&robocell)
        .args(std::env::args_os().skip(1))
        .exec();
    Err(format!("{}: {error}", robocell.display()))
}
