//! `robocell bench` starts this program.

use std::process::ExitCode;

fn main() -> ExitCode {
    robocell_benches::main()
}
