//! The controller of one arm as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    cell_worker::main("controller-proc", controller_proc::process::run)
}
