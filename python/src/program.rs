//! The task program of a Python file: the one of `robocell-task-program`, with the
//! policies of the file.

use std::collections::HashSet;
use std::process::ExitCode;
use std::sync::{Arc, Mutex, PoisonError};

use cell_sim::controller_proc::Controllers;
use pyo3::prelude::*;
use robocell_task::{AnyPolicy, Policies};
use robocell_task_program::main_of;

use crate::policy::{PyPolicy, Reports};

/// A process whose policy raised an exception ends with this.
const EXIT_RAISED: i32 = 1;

/// Policies for every cell: by name, what makes one.
pub(crate) fn policies(makers: Vec<(String, Py<PyAny>)>, reports: &Reports) -> Policies {
    let mut policies = Policies::new();
    for (name, make) in makers {
        let reports = reports.clone();
        policies = policies.policy_for_every_kind(&name, move |cell| {
            let policy: Box<dyn AnyPolicy> = Box::new(PyPolicy::new(&make, cell, &reports)?);
            Ok(policy)
        });
    }
    policies
}

/// Runs the task program with the arguments `words`; its exit code.
#[pyfunction]
pub(crate) fn task_main(
    py: Python<'_>,
    makers: Vec<(String, Py<PyAny>)>,
    words: Vec<String>,
) -> u8 {
    let is_process = words.first().is_some_and(|word| word == "--spec");
    // Of a run in one process the log is printed, unless a program reads the output.
    let prints_log = words.first().is_some_and(|word| word == "run")
        && !words.iter().any(|word| word == "--json");
    let warned = Mutex::new(HashSet::new());
    let reports = Reports {
        on_fault: if is_process {
            Arc::new(end_process)
        } else {
            // The job fails with its reason, and other episodes continue.
            Arc::new(|_, _| {})
        },
        on_warning: Arc::new(move |line| {
            // Each of many seeds has the same.
            let mut warned = warned.lock().unwrap_or_else(PoisonError::into_inner);
            if !prints_log && warned.insert(line.to_owned()) {
                cell_worker::warn(line);
            }
        }),
    };
    let policies = policies(makers, &reports);
    // The policies attach to the interpreter in other threads; held here, it would block them.
    let code =
        py.detach(move || main_of(policies, Controllers::default(), gateways::all(), &words));
    // An ExitCode tells its number to the operating system only.
    (0..=u8::MAX)
        .find(|n| ExitCode::from(*n) == code)
        .unwrap_or(1)
}

/// Ends the task process with one line in its log: the arm holds, and the launcher
/// starts the task again.
#[expect(
    clippy::exit,
    clippy::disallowed_methods,
    reason = "a policy in the middle of a decision cannot return to main"
)]
fn end_process(_error: PyErr, problem: &str) {
    cell_worker::warn(problem);
    std::process::exit(EXIT_RAISED);
}
