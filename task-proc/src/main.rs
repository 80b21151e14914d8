//! The built-in task program: the loop of `robocell-task-program` with the jobs
//! of the demos. A cell file or the command line may name another program with other
//! jobs instead.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    robocell_task_program::main(demos::policies())
}
