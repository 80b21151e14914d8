//! Runs cases made with the two reference libraries, one per line:
//! `cargo run --release -p robocell-behavior --example conformance -- CASES.jsonl`
//!
//! Prints the first failures and, as its closing line, `N passed, M failed`.
#![allow(clippy::print_stdout, reason = "what it is for")]

mod machine;
mod tree;

use std::io::{BufRead, BufReader};
use std::process::ExitCode;

use serde_json::Value;

// A defect fails thousands of generated cases in the same way.
const FAILURES_SHOWN: usize = 10;
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    let files: Vec<String> = std::env::args().skip(1).collect();
    if files.is_empty() {
        println!("usage: conformance CASES.jsonl...");
        return ExitCode::from(BAD_INPUT);
    }
    let (mut passed, mut failed) = (0_usize, 0_usize);
    for file in &files {
        let cases = match std::fs::File::open(file) {
            Ok(opened) => BufReader::new(opened).lines(),
            Err(error) => {
                println!("{file}: {error}");
                return ExitCode::from(BAD_INPUT);
            }
        };
        for (line, case) in (1..).zip(cases) {
            match case
                .map_err(|error| error.to_string())
                .and_then(|c| run(&c))
            {
                Ok(()) => passed += 1,
                Err(message) => {
                    failed += 1;
                    if failed <= FAILURES_SHOWN {
                        println!("{file}:{line}: {message}");
                    }
                }
            }
        }
    }
    println!("{passed} passed, {failed} failed");
    ExitCode::from(u8::from(failed > 0 || passed == 0))
}

fn run(line: &str) -> Result<(), String> {
    let case: Value = serde_json::from_str(line).map_err(|error| error.to_string())?;
    match case.get("kind").and_then(Value::as_str) {
        Some("tree") => tree::run(&case),
        Some("machine") => machine::run(&case),
        kind => Err(format!("no such kind of case: {kind:?}")),
    }
}
