//! The built-in task program: the loop of `robocell-task-program` with the jobs
//! of the demos. Another program with other jobs takes its place where a cell
//! file or the command line names one.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    robocell_task_program::main(demos::policies())
}
