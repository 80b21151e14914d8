//! How the programs of this package end: messages and exit codes, as for all commands of
//! `robocell`.

use std::io::Write as _;
use std::process::ExitCode;

use cell_rt::stdout;

/// Input that cannot be used.
const CONFIGURATION: u8 = 3;

/// Flushes standard output, reports an error on stderr and returns the exit code.
pub fn finish<E: std::fmt::Display>(done: Result<(), E>) -> ExitCode {
    let written = stdout::finish();
    let written = written.map_err(|error| format!("cannot write to standard output: {error}"));
    match done.map_err(|error| error.to_string()).and(written) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            note(&format!("robocell: {error}"));
            ExitCode::from(CONFIGURATION)
        }
    }
}

/// Writes a line to stderr.
pub fn note(line: &str) {
    // Where stderr cannot be written, no channel is left for a report.
    writeln!(std::io::stderr(), "{line}").ok();
}
