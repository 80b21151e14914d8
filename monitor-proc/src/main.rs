//! The monitor as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

use cell_rt::stdout;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    match arguments.next().as_deref() {
        Some("replay") => monitor_proc::replay::show::main(arguments),
        // For `robocell doctor`.
        Some("page") => {
            let has_page = monitor_proc::web::files::has_page();
            let found = if has_page { "built in" } else { "none" };
            stdout::line(found);
            match stdout::finish() {
                Ok(()) => ExitCode::SUCCESS,
                Err(_) => ExitCode::FAILURE,
            }
        }
        _ => cell_worker::main("monitor-proc", monitor_proc::process::run),
    }
}
