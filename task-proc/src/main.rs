//! The task as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    cell_worker::main("task-proc", task_proc::process::run)
}
