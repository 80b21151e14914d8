//! The controller of one arm as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use controller_proc::Controllers;

fn main() -> ExitCode {
    controller_proc::main(&Controllers::default())
}
