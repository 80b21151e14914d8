//! The monitor as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    if arguments.next().as_deref() == Some("replay") {
        return monitor_proc::replay::show::main(arguments);
    }
    cell_worker::main("monitor-proc", monitor_proc::process::run)
}
