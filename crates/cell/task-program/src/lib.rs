//! Turns a registry of policies into a task program.
//!
//! The launcher starts the program as the task process of a cell: it observes,
//! decides, writes its checkpoint and publishes. Users and `robocell` start it
//! with a subcommand: the same cell in one process, many seeds, the verification of a
//! recording, pictures and schemas of its behaviours.
//!
//! This crate defines how a task runs; its decisions are defined by the registry.
#![forbid(unsafe_code)]

mod around;
mod camera;
mod checked;
mod cli;
mod evaluate;
mod exit;
mod failure;
pub mod inspect;
mod message_file;
mod output;
pub mod process;
mod progress;
mod reached;
mod recordings;
mod rows;
pub mod slots;
mod warned;

use std::path::Path;
use std::process::ExitCode;

use cell_model::Data;
use cell_sim::{Program, SimError, eval, run};
use robocell_task::Policies;

/// The interface of controllers, for programs that bring their own.
pub use cell_sim::controller_proc as control;
/// Interfaces to programs of others, for programs that have some.
pub use cell_sim::gateway;

use control::Controllers;
use gateway::Gateways;

pub use cell_run::summary::{RunOutcome, RunSummary};

/// `main` of a task program with these jobs, with the built-in controllers and no gateway.
pub fn main(policies: Policies) -> ExitCode {
    main_with(policies, Controllers::default(), Gateways::new())
}

/// `main` of a program with these jobs that also brings controllers for the arms and gateways:
/// it is started as the task of a cell, and as the controller of each arm that names it.
///
/// The gateways of this project are `robocell_gateways::all()`.
pub fn main_with(policies: Policies, controllers: Controllers, gateways: Gateways) -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    main_of(policies, controllers, gateways, &words)
}

/// As [`main_with`], with these words in place of the arguments of this process.
pub fn main_of(
    policies: Policies,
    controllers: Controllers,
    gateways: Gateways,
    words: &[String],
) -> ExitCode {
    let policies = gateways
        .iter()
        .fold(policies, |policies, gateway| gateway.policies(policies));
    // The launcher starts one program for both roles; only a controller is given an arm.
    if words.iter().any(|word| word == "--arm") {
        return control::main(&controllers);
    }
    // `--spec` first is the start as a process of a cell; `run --spec` is a subcommand.
    if words.first().is_some_and(|word| word == "--spec") {
        return cell_worker::main_of("task", words, |start| process::run(start, &policies));
    }
    let data = cell_files::data();
    let program = Program {
        policies,
        controllers,
        gateways,
        data,
    };
    cli::main(&program, words)
}

/// Runs a cell of the folder `data` to its end, in this process and as fast as it
/// gets, with its default policy: for the tests of a job.
///
/// # Errors
/// [`SimError`] for a cell or a behaviour that cannot be started.
pub fn run_cell(
    policies: &Policies,
    data: &Path,
    demo: &str,
    seed: u64,
) -> Result<RunSummary, SimError> {
    let program = Program {
        // No custom controllers: a test of a job runs with the built-in ones.
        policies: policies.clone(),
        controllers: Controllers::default(),
        gateways: Gateways::new(),
        data: Data::dir(data).with_robots_of(&cell_files::data()),
    };
    // The default policy is looked up in the registry, which a program may extend.
    let mut spec = eval::template(demo, "");
    spec.seed = seed;
    let cell = spec.load_cell_from(&program.data)?;
    program
        .policies
        .default_policy(&cell)
        .clone_into(&mut spec.policy);
    run::to_the_end(&program, &spec, |_| {})
}
