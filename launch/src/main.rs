//! `robocell`: see [`launch::cli`] for what it does.

use std::process::ExitCode;

use clap::Parser;
use launch::cli::Cli;

fn main() -> ExitCode {
    launch::main_of(&Cli::parse())
}
