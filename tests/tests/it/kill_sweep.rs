//! SIGKILL after the decisions of a job, in lockstep over shared memory: the run
//! ends in the state it would have ended in.
//!
//! `ROBOCELL_SWEEP=all` kills after every decision; without it a sample is taken,
//! with another offset for each policy.

#![allow(
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    clippy::cast_possible_truncation,
    reason = "a test fails by panicking, and a series says what it did"
)]

use std::fmt::Write as _;
use std::path::Path;

use robocell_tests::cell::base;
use robocell_tests::program::{finish, robocell};
use robocell_tests::recording::{same, verify};
use serde_json::Value;

/// What two runs of the same have in common.
const KEYS: [&str; 7] = [
    "state_hash",
    "ticks",
    "placed",
    "drops",
    "recoveries",
    "outcome",
    "reason",
];
/// Four processes, as fast as they answer one another; a start that takes long on a
/// busy machine is no further kill.
const LOCKSTEP: [&str; 4] = ["--speed", "max", "--headless", "--no-watchdog"];

/// Runs to the end and gives the summary.
fn run(dir: &Path, demo: &str, options: &[&str], script: &str) -> Value {
    let file = dir.join("script.jsonl");
    std::fs::write(&file, script).expect("the script is written");
    let file = file.display().to_string();
    let fixed = ["run", demo, "--until-done", "--json", "--script", &file];
    let arguments: Vec<&str> = fixed.iter().chain(options).copied().collect();
    let said = finish(robocell(dir, &arguments));
    assert_eq!(said.code, 0, "{said:?}");
    said.json()
}

fn is_whole() -> bool {
    std::env::var("ROBOCELL_SWEEP").is_ok_and(|value| value == "all")
}

/// `killed` noticed nothing of `count` kills.
fn assert_same(killed: &Value, calm: &Value, count: u64) {
    println!(
        "{} {}: {count} kills, hash {}",
        killed["demo"], killed["policy"], killed["state_hash"]
    );
    assert_eq!(killed["task_restarts"], count, "{killed}");
    assert_eq!(killed["script_left"], 0, "{killed}");
    for key in KEYS {
        assert_eq!(killed[key], calm[key], "{key}: {killed}");
    }
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

/// A kill after every `step`th decision of the first `end_s` seconds: half of
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
    let (step, offset) = if is_whole() { (1, 0) } else { (20, offset) };
    let dir = base();
    let options = [&["--policy", policy, "--seed", "2"], &LOCKSTEP[..]].concat();
    let calm = run(dir.path(), demo, &options, "");
    let (script, count) = kills(first_transfer_s(dir.path(), end), step, offset);
    assert!(count > 10, "the transfer was too short to be disturbed");
    let killed = run(dir.path(), demo, &options, &script);
    assert_same(&killed, &calm, count);
}

/// The whole job of few bins, against the same in one process; what was recorded
/// of it is the same when it is computed again.
fn sweep_of_bins(demo: &str, options: &[&str], offset: usize) {
    let dir = base();
    let calm = run(
        dir.path(),
        demo,
        &[options, &["--one-process"]].concat(),
        "",
    );
    // A whole sweep is ten runs: one lasts minutes, and must not seem to hang.
    let (step, offsets) = if is_whole() {
        (10, 0..10)
    } else {
        (150, offset..offset + 1)
    };
    let end_s = calm["sim_time_s"].as_f64().expect("a number");
    for offset in offsets {
        let (script, count) = kills(end_s - 0.02, step, offset);
        assert!(count > 10, "the job was too short to be disturbed");
        let recording = dir.path().join(format!("{offset}.mcap"));
        let name = recording.display().to_string();
        let four = [options, &LOCKSTEP, &["--record", &name]].concat();
        let killed = run(dir.path(), demo, &four, &script);
        assert_same(&killed, &calm, count);
        let report = same(&verify(dir.path(), &recording, &["--json"]));
        let decisions = report["decisions"]["compared"].as_u64();
        assert!(decisions > Some(250), "{report}");
        std::fs::remove_file(&recording).expect("the recording goes");
    }
}

#[test]
fn of_the_state_machine() {
    sweep("franka-stack", "fsm", "RETRACT done", 0);
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_tree_in_code() {
    sweep("franka-stack", "bt", "RETRACT done", 3);
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_trees_from_a_file() {
    sweep("franka-pyramid", "json", "[placed] left", 7);
}

#[test]
fn of_the_table_that_palletizes_an_upside_down_bin() {
    sweep_of_bins("ur10-palletize", &["--bins", "1", "--seed", "2"], 11);
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_matrix_that_has_a_bin_filled_until_it_falls() {
    sweep_of_bins("ur10-fill-bin", &["--seed", "2"], 5);
}

#[test]
#[ignore = "slow: .ci/long"]
fn of_the_matrix_that_flips_and_stacks_a_bin() {
    sweep_of_bins("ur10-bin-stack", &["--bins", "1", "--seed", "1"], 17);
}
