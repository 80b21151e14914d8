//! `cell-sim`: what `robocell` runs for `--one-process`, `eval` and the benches
//! of the cores.
#![forbid(unsafe_code)]

use std::process::ExitCode;

mod cli;

fn main() -> ExitCode {
    match cli::run() {
        Ok(code) => code,
        Err(error) => {
            eprintln!("cell-sim: {error}");
            ExitCode::from(3)
        }
    }
}
