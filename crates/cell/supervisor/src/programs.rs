//! The programs of a cell, beside our own.

use std::path::{Path, PathBuf};

use cell_run::spec::RunSpec;
use ipc_types::topic::Process;

use crate::failure::Failure;

/// The built-in task program.
const TASK: &str = "task-proc";

/// The programs of a cell that are not the built-in ones.
#[derive(Clone, Debug, Default)]
pub(crate) struct Programs {
    task: Option<PathBuf>,
    /// By arm.
    controllers: Vec<Option<PathBuf>>,
}

impl Programs {
    /// Those of a run.
    pub(crate) fn of(spec: &RunSpec) -> Self {
        Self {
            task: spec.task_program.clone(),
            controllers: spec.controller_programs.clone(),
        }
    }

    /// The program of the user that `process` is started with.
    pub(crate) fn own(&self, process: Process) -> Option<&Path> {
        match process {
            Process::Task => self.task.as_deref(),
            Process::Controller(arm) => self.controllers.get(usize::from(arm))?.as_deref(),
            Process::Physics | Process::Monitor => None,
        }
    }

    /// The program of a process.
    pub(crate) fn path(&self, process: Process) -> Result<PathBuf, Failure> {
        if let Some(own) = self.own(process) {
            return Ok(own.to_owned());
        }
        match process {
            Process::Physics => beside("physics-proc"),
            Process::Controller(_) => beside("controller-proc"),
            Process::Task => beside(TASK),
            Process::Monitor => beside("monitor-proc"),
        }
    }
}

/// Path of a task program, or of the built-in one.
pub fn task_program(program: Option<&Path>) -> Result<PathBuf, Failure> {
    program.map_or_else(|| beside(TASK), |path| Ok(path.to_owned()))
}

/// The path of `program` beside our own executable.
pub fn beside(program: &str) -> Result<PathBuf, Failure> {
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
