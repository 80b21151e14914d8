//! SIGKILL after the decisions of a transfer, in lockstep over shared memory:
//! the run ends in the state it would have ended in.
//!
//! `ROBOCELL_SWEEP=all` kills after every decision; without it every 20th, with
//! another offset for each policy.
#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    reason = "a test that cannot go on has failed, and a series says what it did"
)]

use std::fmt::Write as _;
use std::path::Path;

use robocell_tests::cell::base;
use robocell_tests::program::{finish, robocell};
use serde_json::Value;

/// Runs to the end and gives the summary.
fn run(dir: &Path, demo: &str, policy: &str, script: &str) -> Value {
    let file = dir.join("script.jsonl");
    std::fs::write(&file, script).expect("the script is written");
    let file = file.display().to_string();
    let arguments = [
        "run",
        demo,
        "--policy",
        policy,
        "--seed",
        "2",
        "--speed",
        "max",
        "--headless",
        "--until-done",
        "--json",
        "--script",
        &file,
    ];
    let said = finish(robocell(dir, &arguments));
    assert_eq!(said.code, 0, "{said:?}");
    said.json()
}

/// Seconds at which the first transfer was over, from the task's log.
fn first_transfer_s(dir: &Path, end: &str) -> f64 {
    let log = std::fs::read_to_string(dir.join("cell/logs/trace.log")).expect("the task's log");
    let line = log
        .lines()
        .find(|line| line.contains(end))
        .unwrap_or_else(|| panic!("no {end:?} in\n{log}"));
    let seconds = line.split_whitespace().next().expect("a time");
    seconds.parse().expect("a number")
}

/// A kill after every `step`th decision of the first `end_s` seconds, half of
/// them while the decision is being made, half after it was sent.
fn kills(end_s: f64, step: usize, offset: usize) -> (String, u64) {
    let mut script = String::new();
    let mut count = 0;
    let mut decision = 1 + offset;
    while (decision as f64) * 0.01 < end_s {
        let ticks = decision * 10 + 5 * (count as usize % 2);
        writeln!(
            script,
            r#"{{"at_s": {}.{:03}, "do": "kill", "process": "task"}}"#,
            ticks / 1000,
            ticks % 1000
        )
        .expect("text grows");
        count += 1;
        decision += step;
    }
    (script, count)
}

fn sweep(demo: &str, policy: &str, end: &str, offset: usize) {
    let all = std::env::var("ROBOCELL_SWEEP").is_ok_and(|value| value == "all");
    let (step, offset) = if all { (1, 0) } else { (20, offset) };
    let dir = base();
    let calm = run(dir.path(), demo, policy, "");
    let (script, count) = kills(first_transfer_s(dir.path(), end), step, offset);
    assert!(count > 10, "the transfer was too short to be disturbed");
    let killed = run(dir.path(), demo, policy, &script);
    println!(
        "{demo} {policy}: {count} kills, hash {}",
        killed["state_hash"]
    );
    assert_eq!(killed["task_restarts"], count, "{killed}");
    assert_eq!(killed["script_left"], 0, "{killed}");
    for key in ["state_hash", "ticks", "placed", "drops", "outcome"] {
        assert_eq!(killed[key], calm[key], "{policy}: {key}");
    }
}

#[test]
fn of_the_state_machine() {
    sweep("franka-stack", "fsm", "RETRACT done", 0);
}

#[test]
fn of_the_tree_in_code() {
    sweep("franka-stack", "bt", "RETRACT done", 3);
}

#[test]
fn of_the_trees_from_a_file() {
    sweep("franka-pyramid", "json", "[placed] left", 7);
}
