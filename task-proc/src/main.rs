//! The built-in task program: the loop of `robocell-task-program` with the jobs
//! of the demos. A cell file or the command line may name another program with other
//! jobs instead.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use robocell_task_program::control::Controllers;

fn main() -> ExitCode {
    robocell_task_program::main_with(demos::policies(), Controllers::default(), gateways::all())
}
