//! The launcher: run directory, services, supervision, and the commands that
//! talk to a running cell. It runs no control code and links no process.
#![forbid(unsafe_code)]

mod app;
mod asked;
pub mod chaos;
mod child;
pub mod cli;
mod cli_behaviour;
mod cli_common;
mod cli_eval;
mod cli_hand;
mod cli_page;
mod cli_robot;
mod cli_values;
mod client;
mod complete;
mod control;
mod eval;
pub mod failure;
mod flight;
mod leftovers;
pub mod lock;
mod man;
mod new;
mod output;
mod page;
mod plot;
mod programs;
mod progress;
mod record;
mod replay;
pub mod run;
pub mod rundir;
mod say;
mod shot;
pub mod supervisor;
mod task_program;

use std::process::ExitCode;

/// Does what the command line says and turns a failure into its exit code.
pub fn main_of(cli: &cli::Cli) -> ExitCode {
    run::preflight::raise_stack();
    match app::dispatch(cli) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if !failure.message.is_empty() {
                say::warn(&failure);
            }
            failure.code.into()
        }
    }
}
