//! `robocell`: see [`launch::args`] for its commands.

use std::ffi::OsString;
use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<OsString> = std::env::args_os().collect();
    launch::main(&words)
}
