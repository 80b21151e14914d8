//! `cargo robocell ...` in a checkout: builds every program of the cell once,
//! then becomes `robocell` with the same arguments. `robocell` itself never
//! calls cargo.

use std::ffi::OsString;
use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// Packages whose programs a cell needs.
const PACKAGES: [&str; 6] = [
    "robocell-launch",
    "robocell-physics",
    "robocell-controller",
    "robocell-fci-proc",
    "robocell-task-proc",
    "robocell-monitor",
];

/// Subcommands with a program of their own, and its package: built only for
/// those who use it.
const OPTIONAL: [(&str, &str); 4] = [
    ("assets", "robocell-cell-assets"),
    ("bench", "robocell-benches"),
    ("export", "robocell-export"),
    ("spheres", "robocell-cell-assets"),
];

/// Tells `robocell` where the sources of the page are.
const ENV_UI: &str = "ROBOCELL_UI_DIR";

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
    let manifest = checkout().join("Cargo.toml");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut build = Command::new(cargo);
    build
        // Cells and robots are read from the checkout, so that an edited one
        // takes effect without a build.
        .args(["build", "--release", "--bins", "--no-default-features"])
        .arg("--manifest-path")
        .arg(&manifest);
    // The first build takes minutes and has to be seen; later ones only wait.
    if own.with_file_name("robocell").is_file() {
        build.arg("--quiet");
    }
    for package in PACKAGES {
        build.args(["--package", package]);
    }
    if let Some(package) = optional(std::env::args_os().skip(1)) {
        build.args(["--package", package]);
    }
    let status = build
        .status()
        .map_err(|error| format!("cannot start cargo: {error}"))?;
    if !status.success() {
        return Ok(ExitCode::from(3));
    }
    let robocell = own.with_file_name("robocell");
    let mut become_it = Command::new(&robocell);
    become_it.args(std::env::args_os().skip(1));
    // With CARGO_TARGET_DIR the programs lie outside of the checkout.
    if std::env::var_os(ENV_UI).is_none() {
        become_it.env(ENV_UI, page_sources());
    }
    let error = become_it.exec();
    Err(format!("{}: {error}", robocell.display()))
}

/// This checkout: three levels above this package.
fn checkout() -> PathBuf {
    let own = Path::new(env!("CARGO_MANIFEST_DIR"));
    own.ancestors().nth(3).unwrap_or(own).to_owned()
}

/// Directory of the page's sources in this checkout.
fn page_sources() -> PathBuf {
    checkout().join("monitor-proc").join("ui")
}

/// The package that the subcommand needs besides: the first word, whatever flags
/// are before it.
fn optional(mut arguments: impl Iterator<Item = OsString>) -> Option<&'static str> {
    let is_option = |argument: &OsString| argument.as_encoded_bytes().starts_with(b"-");
    let word = arguments.find(|argument| !is_option(argument))?;
    // The one option of another subcommand that starts a program of its own.
    if word == "replay" && arguments.any(|argument| argument == "--actions") {
        return Some("robocell-export");
    }
    let (_, package) = OPTIONAL.iter().find(|(name, _)| word == *name)?;
    Some(package)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_found_wherever_cargo_builds() {
        assert!(page_sources().join("package.json").is_file());
    }

    #[test]
    fn what_few_use_is_built_when_they_ask_for_it() {
        let built = |line: &str| optional(line.split(' ').map(OsString::from));
        assert_eq!(built("bench physics"), Some("robocell-benches"));
        assert_eq!(built("--json bench ipc"), Some("robocell-benches"));
        assert_eq!(built("assets fetch"), Some("robocell-cell-assets"));
        assert_eq!(built("replay --actions data"), Some("robocell-export"));
        assert_eq!(built("replay run.mcap"), None);
        assert_eq!(built("run behavior"), None);
        assert_eq!(built("list bench"), None);
    }
}
