//! The network interface of a Franka arm as a process.
#![forbid(unsafe_code)]

use std::process::ExitCode;

fn main() -> ExitCode {
    fci_proc::main()
}
