//! The programs of a cell, beside our own.

use std::path::{Path, PathBuf};

use ipc_types::topic::Process;

use crate::failure::Failure;

/// The built-in task program.
const TASK: &str = "task-proc";

/// The program of a process; `task` is that of the task where it is not the
/// built-in one.
pub(crate) fn program(process: Process, task: Option<&Path>) -> Result<PathBuf, Failure> {
    match process {
        Process::Physics => beside("physics-proc"),
        Process::Controller(_) => beside("controller-proc"),
        Process::Task => task_program(task),
        Process::Monitor => beside("monitor-proc"),
    }
}

/// Path of a task program, or of the built-in one.
pub(crate) fn task_program(program: Option<&Path>) -> Result<PathBuf, Failure> {
    program.map_or_else(|| beside(TASK), |path| Ok(path.to_owned()))
}

/// The path of `program` beside our own executable.
pub(crate) fn beside(program: &str) -> Result<PathBuf, Failure> {
    let own = std::env::current_exe().map_err(Failure::configuration)?;
    let path = own.with_file_name(program);
    if path.is_file() {
        return Ok(path);
    }
    Err(Failure::configuration(format!(
        "{} is missing: robocell looks for its processes beside its own executable; \
         `cargo build --workspace --bins` builds them all",
        path.display()
    )))
}
