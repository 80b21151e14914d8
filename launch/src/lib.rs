//! The command line: `run`, which starts a cell, and the commands that talk to a running
//! one. Supervision is the package `supervisor`.
#![forbid(unsafe_code)]

mod app;
pub mod args;
mod asked;
mod camera;
pub mod chaos;
mod client;
mod command_line;
mod complete;
mod eval;
mod man;
mod new;
mod output;
mod page;
mod plot;
mod progress;
mod record;
mod replay;
pub mod run;
mod say;
mod schema;
mod shell;
mod suggestion;
mod task_program;

use std::ffi::OsString;
use std::process::ExitCode;

use cell_rt::stdout;
use clap::FromArgMatches as _;
use supervisor::failure::{Code, Context as _, Failure};

/// Does what the command line `words` says and turns a failure into its exit code.
pub fn main(words: &[OsString]) -> ExitCode {
    // First: the programs that are started later inherit the limit.
    supervisor::run::files::preflight::raise_stack();
    let done = parse(words).and_then(|cli| cli.map_or(Ok(()), |cli| app::dispatch(&cli)));
    // What was done is of no use to a script that reads less of it.
    let written = stdout::finish().cannot("write to standard output");
    let done = match (done, written) {
        (Ok(()), written) => written,
        (done, Ok(())) => done,
        (Err(failure), Err(unwritten)) => {
            // The exit code is that of the command, which failed first.
            say::warn(unwritten);
            Err(failure)
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            // Empty where clap or another program has printed the reason already.
            if !failure.message.is_empty() {
                say::warn(&failure);
            }
            failure.code.into()
        }
    }
}

/// The command line; `None` where only help was asked for.
fn parse(words: &[OsString]) -> Result<Option<args::Cli>, Failure> {
    // Run files, recordings and messages are UTF-8. A path that is not would be changed on
    // its way, and another file be reported as missing.
    if let Some(word) = words.iter().find(|word| word.to_str().is_none()) {
        let shown = word.as_encoded_bytes().escape_ascii();
        return Err(Failure::usage(format!(
            "`{shown}` is not valid UTF-8; only arguments and paths in UTF-8 are accepted: rename \
             the file or folder"
        )));
    }
    let matches = command_line::command().try_get_matches_from(command_line::cell_last(words));
    let error = match matches.and_then(|matches| args::Cli::from_arg_matches(&matches)) {
        Ok(cli) => return Ok(Some(cli)),
        Err(error) => error,
    };
    if error.use_stderr() {
        // No other stream is left to report a failed write to stderr.
        error.print().ok();
        return Err(Failure::silent(Code::Usage));
    }
    // Help or version: a reader that ends early, as `head` does, is not a failure.
    match error.print() {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(error).cannot("write to standard output")
        }
        _ => Ok(None),
    }
}
