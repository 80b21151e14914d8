//! What the reference library did with small trees, row by row (its version
//! 2.6.0). Per tick: status of the root, then of the leaves by name; then how
//! often each leaf was started, ticked and stopped.

#![allow(
    clippy::unwrap_used,
    clippy::needless_pass_by_value,
    reason = "in tests"
)]

use crate::tree;

use serde_json::{Value, json};

fn row(tree: &Value, ticks: &str, counts: &str) {
    let counts: Vec<(&str, Vec<u64>)> = counts
        .split_whitespace()
        .map(|leaf| {
            let (name, numbers) = leaf.split_once('=').unwrap();
            (
                name,
                numbers.split('/').map(|n| n.parse().unwrap()).collect(),
            )
        })
        .collect();
    let leaves = |letters: &str| -> Value {
        let letters = letters.chars().map(|letter| json!(letter.to_string()));
        counts
            .iter()
            .map(|(name, _)| (*name).to_owned())
            .zip(letters)
            .collect()
    };
    let ticks = ticks.split_whitespace().map(|tick| {
        let (root, letters) = tick.split_once(':').unwrap();
        json!({"root": root, "leaves": leaves(letters)})
    });
    let ticks: Vec<Value> = ticks.collect();
    let numbers = counts.iter().map(|(name, n)| {
        let counts = json!({"initialise": n[0], "update": n[1], "stopped": n[2]});
        ((*name).to_owned(), counts)
    });
    let counts: Value = numbers.collect();
    let case = json!({"id": "row", "tree": tree, "ticks": ticks, "counts": counts});
    assert_eq!(tree::run(&case), Ok(()));
}

/// The leaf `A RRS`.
fn leaf(written: &str) -> Value {
    let (name, script) = written.split_once(' ').unwrap();
    json!({"type": "leaf", "name": name, "script": script})
}

fn composite<const N: usize>(kind: &str, memory: bool, children: [Value; N]) -> Value {
    json!({"type": kind, "memory": memory, "children": children.to_vec()})
}

fn sequence<const N: usize>(memory: bool, children: [&str; N]) -> Value {
    composite("sequence", memory, children.map(leaf))
}

fn selector<const N: usize>(memory: bool, children: [&str; N]) -> Value {
    composite("selector", memory, children.map(leaf))
}

fn parallel<const N: usize>(policy: &str, synchronise: bool, children: [&str; N]) -> Value {
    json!({"type": "parallel", "policy": policy, "synchronise": synchronise,
           "children": children.map(leaf).to_vec()})
}

fn around(decorator: &str, child: &str) -> Value {
    json!({"type": decorator, "child": leaf(child)})
}

fn counting(decorator: &str, count: u32, child: &str) -> Value {
    json!({"type": decorator, "count": count, "child": leaf(child)})
}

#[test]
fn sequences() {
    row(
        &sequence(true, ["A S", "B RS", "C R"]),
        "R:SR- R:SSR R:SSR",
        "A=1/1/0 B=1/2/0 C=1/2/0",
    );
    row(
        &sequence(false, ["A SR", "B R"]),
        "R:SR R:R- R:R-",
        "A=2/3/0 B=1/1/1",
    );
    row(
        &sequence(true, ["A SF", "B RRS"]),
        "R:SR R:SR S:SS F:F-",
        "A=2/2/1 B=1/3/1",
    );
    row(
        &sequence(true, ["A S", "B F", "C S"]),
        "F:SF- F:SF-",
        "A=2/2/1 B=2/2/1 C=0/0/0",
    );
    row(&sequence(true, []), "S:", "");
}

#[test]
fn memory_decides_whether_a_guard_is_asked_again() {
    row(
        &sequence(false, ["A SF", "B RRS"]),
        "R:SR F:F-",
        "A=2/2/0 B=1/1/1",
    );
}

#[test]
fn selectors() {
    row(
        &selector(false, ["A FS", "B R"]),
        "R:FR S:S- S:S-",
        "A=3/3/0 B=1/1/1",
    );
    row(
        &selector(false, ["A F", "B RS", "C R"]),
        "R:FR- S:FS- S:FS-",
        "A=3/3/0 B=2/3/0 C=0/0/0",
    );
    row(&selector(true, []), "F:", "");
}

#[test]
fn a_selector_with_memory_marks_those_it_skips_invalid() {
    let tree = selector(true, ["A FS", "B RRF", "C S"]);
    row(&tree, "R:FR- R:-R- S:-FS S:SFS", "A=2/2/1 B=1/3/0 C=1/1/0");
}

#[test]
fn a_branch_that_was_preempted_begins_anew() {
    let normal = sequence(true, ["B S", "C R"]);
    let tree = composite("selector", false, [leaf("A FFSF"), normal]);
    let ticks = "R:FSR R:FSR S:S-- R:FSR R:FSR";
    row(&tree, ticks, "A=5/5/0 B=2/2/1 C=2/4/1");
    let recovery = sequence(true, ["A FSF", "X RS"]);
    let tree = composite("selector", false, [recovery, leaf("B R")]);
    let ticks = "R:FR- R:S-R S:S-S R:FR- R:FR-";
    row(&tree, ticks, "A=4/4/3 B=2/3/1 X=1/2/1");
}

#[test]
fn a_reactive_root_keeps_the_memory_of_what_runs() {
    let normal = sequence(true, ["B S", "C RRS"]);
    let tree = composite("selector", false, [leaf("A F"), normal]);
    row(&tree, "R:FSR R:FSR S:FSS", "A=3/3/0 B=1/1/0 C=1/3/0");
}

#[test]
fn a_recovery_that_fails_at_once_interrupts_nothing() {
    let recovery = sequence(true, ["A FSF", "X F"]);
    let tree = composite("selector", false, [recovery, leaf("B R")]);
    row(&tree, "R:FR- R:SRF R:FR-", "A=3/3/2 B=1/3/0 X=1/1/1");
}

#[test]
fn a_guard_in_front_of_a_sequence_is_asked_every_tick() {
    let work = sequence(true, ["B S", "C R"]);
    let tree = composite("sequence", false, [leaf("A SSF"), work]);
    row(&tree, "R:SSR R:SSR F:F-- F:F--", "A=4/4/1 B=1/1/1 C=1/2/1");
}

#[test]
fn parallels() {
    let all = "success_on_all";
    row(
        &parallel(all, false, ["A SRS", "B RRS"]),
        "R:SR R:RR S:SS",
        "A=2/3/0 B=1/3/0",
    );
    row(
        &parallel(all, true, ["A SRS", "B RRS"]),
        "R:SR R:SR S:SS",
        "A=1/1/0 B=1/3/0",
    );
    row(
        &parallel(all, false, ["A F", "B R"]),
        "F:F-",
        "A=1/1/0 B=1/1/1",
    );
    let one = "success_on_one";
    row(
        &parallel(one, false, ["A S", "B R"]),
        "S:S-",
        "A=1/1/0 B=1/1/1",
    );
    row(
        &parallel(one, false, ["A F", "B S"]),
        "F:FS",
        "A=1/1/0 B=1/1/0",
    );
    let mut selected = parallel("success_on_selected", false, ["A S", "B R"]);
    selected["selected"] = json!([0]);
    row(&selected, "S:S-", "A=1/1/0 B=1/1/1");
    row(&parallel(all, false, []), "S:", "");
}

#[test]
fn converters() {
    row(
        &around("running_is_failure", "A RSF"),
        "F:- S:S F:F",
        "A=3/3/1",
    );
    row(
        &around("failure_is_running", "A FFS"),
        "R:F R:F S:S",
        "A=3/3/0",
    );
    row(&around("success_is_failure", "A S"), "F:S", "A=1/1/0");
    row(&around("inverter", "A RSF"), "R:R F:S S:F", "A=2/3/0");
}

#[test]
fn loops_take_a_tick_a_run_and_begin_anew_after_the_last() {
    row(&counting("repeat", 3, "A S"), "R:S R:S S:S R:S", "A=4/4/0");
    row(&around("repeat", "A S"), "R:S R:S R:S R:S", "A=4/4/0");
    row(&counting("retry", 2, "A F"), "R:F F:F R:F", "A=3/3/0");
}

#[test]
fn a_one_shot_has_one_shot() {
    let mut tree = around("one_shot", "A FSF");
    tree["policy"] = json!("on_success");
    row(&tree, "F:F S:S S:S S:S", "A=2/2/0");
    tree["policy"] = json!("on_completion");
    row(&tree, "F:F F:F F:F", "A=1/1/0");
}

#[test]
fn a_guard_that_does_not_hold_stops_its_child() {
    let mut tree = around("eternal_guard", "A R");
    tree["condition"] = json!("TTFT");
    row(&tree, "R:R R:R F:- R:R", "A=2/3/1");
}
