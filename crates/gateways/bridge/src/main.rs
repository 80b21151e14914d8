//! The bridge as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use bridge_proc::{args::Args, bridge, log};
use clap::Parser as _;

fn main() -> ExitCode {
    match bridge::run(&Args::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            log::line(format_args!("error: {error}"));
            ExitCode::from(3)
        }
    }
}
