//! The monitor as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    cell_worker::main("monitor-proc", monitor_proc::process::run)
}
