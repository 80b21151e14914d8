//! The cost of a tick: the 27 nodes of a pick-and-place tree, ten ticks a phase,
//! with leaves that do almost nothing.
//! `cargo run --release -p robocell-behavior --features measure --example tree_cost`; with a number as its
//! argument it ticks that many times, once, for an instruction counter.
#![allow(clippy::print_stdout, reason = "what it is for")]

mod pick_place;

use std::process::ExitCode;
use std::time::Instant;

use pick_place::{pick_and_place, run};

// The median of many short rounds is not moved by other processes of the machine.
const ROUNDS: usize = 201;
const TICKS_A_ROUND: u64 = 10_000;

fn main() -> ExitCode {
    let mut tree = match pick_and_place() {
        Ok(tree) => tree,
        Err(error) => {
            println!("{error}");
            return ExitCode::FAILURE;
        }
    };
    if let Some(ticks) = std::env::args().nth(1).and_then(|n| n.parse().ok()) {
        println!("{} calls of leaves", run(&mut tree, ticks));
        return ExitCode::SUCCESS;
    }
    let mut costs: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            // A round is long against the resolution of the clock.
            let begin = Instant::now();
            std::hint::black_box(run(&mut tree, TICKS_A_ROUND));
            begin.elapsed().as_secs_f64() * 1e9 / TICKS_A_ROUND as f64
        })
        .collect();
    costs.sort_unstable_by(f64::total_cmp);
    let median = costs.get(ROUNDS / 2).copied().unwrap_or_default();
    let least = costs.first().copied().unwrap_or_default();
    let mut record = Vec::new();
    tree.save(&mut record);
    let nodes = tree.graph().nodes.len();
    let bytes = record.len();
    println!("{nodes} nodes: {median:.1} ns a tick (least {least:.1}), record of {bytes} bytes");
    ExitCode::SUCCESS
}
