//! Turns a registry of policies into a task program.
//!
//! The launcher starts the program as the task process of a cell: it observes,
//! decides, writes its checkpoint and publishes. People and `robocell` start it
//! with a subcommand: the same cell in one process, many seeds, a recording
//! computed again, pictures and schemas of its behaviours.
//!
//! What may be changed here: how a task runs. What it decides is in the registry.
#![forbid(unsafe_code)]

mod cli;
pub mod inspect;
pub mod process;
pub mod slots;

use std::process::ExitCode;

use cell_sim::Program;
use robocell_task::Policies;

/// `main` of a task program with these jobs.
pub fn main(policies: Policies) -> ExitCode {
    if std::env::args().nth(1).is_some_and(|word| word == "--spec") {
        return cell_worker::main("task", |start| process::run(start, &policies));
    }
    let data = cell_files::data();
    cli::main(&Program { policies, data })
}
