//! The task program.

use std::process::ExitCode;

use robocell_task_program::control::Controllers;

fn main() -> ExitCode {
    let controllers = Controllers::default();
    robocell_task_program::main_with({{crate}}::policies(), controllers, robocell_gateways::all())
}
