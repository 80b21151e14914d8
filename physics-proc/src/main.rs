//! The robot and the world as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    cell_worker::main("physics-proc", physics_proc::process::run)
}
