//! Long series of the cells with bins, one line per seed and one at the end.
//!
//!     cargo run --release -p robocell-cell-sim --features measure --example bins -- ur10-palletize 1 30
//!     cargo run --release -p robocell-cell-sim --features measure --example bins -- ur10-bin-stack 1 5
//!     cargo run --release -p robocell-cell-sim --features measure --example bins -- ur10-fill-bin 1 30
//!
//! With `LINES` in the environment, the log lines of the task and every contact
//! of the arm, too.
#![allow(
    clippy::expect_used,
    clippy::print_stdout,
    reason = "a program for people who measure"
)]

mod fill;
mod stack;
mod touches;
mod watched;

use std::process::ExitCode;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().collect();
    let demo = args.get(1).map_or("ur10-palletize", String::as_str);
    let number = |index: usize| args.get(index).and_then(|text| text.parse::<u64>().ok());
    let first = number(2).unwrap_or(1);
    let seeds = first..=number(3).unwrap_or(first);
    let good = match demo {
        "ur10-fill-bin" => fill::series(seeds),
        "ur10-palletize" | "ur10-bin-stack" => stack::series(demo, seeds),
        _ => {
            println!(
                "'{demo}' has no series; there are ur10-palletize, ur10-bin-stack and ur10-fill-bin"
            );
            false
        }
    };
    if good {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
