//! `robocell export` and `robocell replay --actions` start this program.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    export::main()
}
