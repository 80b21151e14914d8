//! The task program.

use std::process::ExitCode;

fn main() -> ExitCode {
    robocell_task_program::main({{crate}}::policies())
}
