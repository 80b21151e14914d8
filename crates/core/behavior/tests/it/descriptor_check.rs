//! Findings in files and trees that load.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::too_many_lines,
    reason = "in tests"
)]

use crate::descriptor_common;

use std::collections::BTreeMap;
use std::fmt::Write;

use behavior::board::{Board, In};
use behavior::descriptor::{self, Source};
use behavior::tree::check::check;
use behavior::tree::{Kind, Memory, Node};
use descriptor_common::{GOOD, Toy, library};

fn findings(root: &str, keys: &str) -> String {
    let text = format!(
        r#"{{"format": "behavior-tree/1", "name": "t", "blackboard": {{"local": {{{keys}}}}}, "root": {root}}}"#
    );
    let source = Source {
        file: "t.json",
        text: &text,
        include: &|_| Err(String::new()),
    };
    let found = descriptor::check(&source, &library(), &BTreeMap::new(), &Board::new());
    let mut lines = String::new();
    for finding in found.unwrap_or_else(|errors| panic!("{errors}")) {
        writeln!(lines, "{} {}", finding.rule, finding.place).unwrap();
    }
    lines
}

const MOVE: &str = r#""type": "MoveTo", "ports": {"target": [0, 0, 0]}"#;
const WAIT: &str = r#""type": "Wait", "ports": {"seconds": 1}"#;
const SEEN: &str = r#""type": "IsSeen", "ports": {"thing": "red"}"#;

fn composite(head: &str, children: &[&str]) -> String {
    let mut parts = Vec::new();
    for (child, id) in children.iter().zip('a'..) {
        parts.push(format!(r#"{{"id": "{id}", {child}}}"#));
    }
    let children = parts.join(", ");
    format!(r#"{{"id": "r", {head}, "children": [{children}]}}"#)
}

#[test]
fn a_good_file_has_no_findings() {
    let source = Source {
        file: "t.json",
        text: GOOD,
        include: &|_| Err(String::new()),
    };
    let found = descriptor::check(&source, &library(), &BTreeMap::new(), &Board::new()).unwrap();
    assert_eq!(found, []);
}

#[test]
fn children_that_can_never_run_are_found() {
    let selector = r#""type": "Selector""#;
    let sequence = r#""type": "Sequence""#;
    let forced = r#""type": "MoveTo", "ports": {"target": [0, 0, 0]},
        "modifiers": [{"type": "ForceStatus", "ports": {"status": "failure"}}]"#;
    let never = "never_runs b\n";
    assert_eq!(findings(&composite(selector, &[WAIT, MOVE]), ""), never);
    assert_eq!(findings(&composite(sequence, &[forced, MOVE]), ""), never);
    assert_eq!(findings(&composite(selector, &[forced, MOVE]), ""), "");
    assert_eq!(findings(&composite(sequence, &[WAIT, MOVE]), ""), "");
    let endless = r#""type": "MoveTo", "ports": {"target": [0, 0, 0]},
        "modifiers": [{"type": "Repeat"}]"#;
    assert_eq!(findings(&composite(sequence, &[endless, MOVE]), ""), never);
}

#[test]
fn memory_that_does_not_fit_the_children_is_found() {
    let sequence = r#""type": "Sequence""#;
    let reactive = r#""type": "Sequence", "ports": {"memory": false}"#;
    assert_eq!(
        findings(&composite(sequence, &[SEEN, SEEN]), ""),
        "memory_of_conditions r\n"
    );
    assert_eq!(findings(&composite(reactive, &[SEEN, SEEN]), ""), "");
    assert_eq!(findings(&composite(reactive, &[SEEN, MOVE]), ""), "");
    assert_eq!(
        findings(&composite(reactive, &[MOVE, MOVE]), ""),
        "reactive_runners r\n"
    );
}

#[test]
fn times_that_cannot_be_met_are_found() {
    let limited = |seconds: f64| {
        format!(
            r#""type": "MoveTo", "ports": {{"target": [0, 0, 0]}},
            "modifiers": [{{"type": "Timeout", "ports": {{"seconds": {seconds}}}}}]"#
        )
    };
    let outer =
        r#""type": "Sequence", "modifiers": [{"type": "Timeout", "ports": {"seconds": 2}}]"#;
    let long = r#""type": "Wait", "ports": {"seconds": 3}"#;
    assert_eq!(
        findings(&composite(outer, &[&limited(2.5), long, WAIT]), ""),
        "timeout_longer a\nalways_times_out b\n"
    );
    // The inner one of two equal timeouts runs out first.
    assert_eq!(findings(&composite(outer, &[&limited(2.0), WAIT]), ""), "");
}

#[test]
fn a_recovery_that_succeeds_before_something_else_is_found() {
    let tree = |status: &str| {
        format!(
            r#"{{"id": "r", "type": "Sequence", "children": [
            {{"id": "s", "type": "Selector", "children": [
              {{"id": "recover", {MOVE}, "modifiers": [
                {{"type": "CheckBlackboard", "abort": "both", "ports": {{"key": {{"bb": "local.lost"}}, "equals": true}}}},
                {{"type": "ForceStatus", "ports": {{"status": "{status}"}}}}]}},
              {{"id": "normal", {MOVE}}}]}},
            {{"id": "after", {MOVE}}}]}}"#
        )
    };
    let key = r#""lost": {"type": "bool", "default": false}"#;
    assert_eq!(
        findings(&tree("success"), key),
        "recovery_succeeds recover\n"
    );
    assert_eq!(findings(&tree("failure"), key), "");
}

#[test]
fn keys_read_or_written_in_vain_are_found() {
    let check = r#""type": "CheckBlackboard", "ports": {"key": {"bb": "local.in"}, "equals": 1}"#;
    let set = r#""type": "SetBlackboard", "ports": {"key": {"bb": "local.out"}, "value": 1}"#;
    let keys = r#""in": {"type": "integer"}, "out": {"type": "integer"}, "idle": {"type": "bool"}"#;
    assert_eq!(
        findings(&composite(r#""type": "Sequence""#, &[check, set]), keys),
        "unused_key t.json:1:124\nread_never_written local.in\nwritten_never_read local.out\n"
    );
}

#[test]
fn trees_in_code_are_looked_over_too() {
    let wait = |id, seconds| Node::<Toy>::new(id, "wait", Kind::Wait(In::Literal(seconds)), vec![]);
    let root = Node::selector("root", Memory::No, vec![wait("a", 1.0), wait("b", 2.0)]);
    let found = check(&root, &Board::new(), &Board::new(), &library());
    assert_eq!(
        found.first().map(ToString::to_string).as_deref(),
        Some(
            "b: can never run: 'a' before it in 'root' never fails; reorder or remove it [never_runs]"
        )
    );
    assert_eq!(found.len(), 1);
}

#[test]
fn composites_without_children_are_found() {
    for head in [
        r#""type": "Sequence""#,
        r#""type": "Selector""#,
        r#""type": "Parallel""#,
    ] {
        assert_eq!(findings(&composite(head, &[]), ""), "empty_composite r\n");
    }
    let each = r#"{"id": "r", "type": "ForEach", "as": "x", "items": [],
        "children": [{"id": "a", "type": "Wait", "ports": {"seconds": 1}}]}"#;
    assert_eq!(findings(each, ""), "empty_composite r\n");
}

#[test]
fn two_leaves_of_a_parallel_that_drive_the_same_are_found() {
    let both = composite(r#""type": "Parallel""#, &[MOVE, WAIT, MOVE]);
    assert_eq!(findings(&both, ""), "parallel_drivers r\n");
    let below = format!(
        r#""type": "Sequence", "children": [{{"id": "x", {WAIT}}}, {{"id": "y", {MOVE}}}]"#
    );
    let below = composite(r#""type": "Parallel""#, &[MOVE, &below]);
    assert_eq!(findings(&below, ""), "parallel_drivers r\n");
    let one = composite(r#""type": "Parallel""#, &[MOVE, WAIT]);
    assert_eq!(findings(&one, ""), "");
    let in_turn = composite(r#""type": "Sequence""#, &[MOVE, MOVE]);
    assert_eq!(findings(&in_turn, ""), "");
}

#[test]
fn names_of_another_library_get_ours() {
    for (name, ours) in [
        (
            "ReactiveSequence",
            "write Sequence with \"ports\": {\"memory\": false}",
        ),
        ("ReactiveFallback", "write Selector"),
        (
            "Fallback",
            "write Selector with \"ports\": {\"memory\": true}",
        ),
        ("ForceSuccess", "ForceStatus"),
        ("RetryUntilSuccessful", "write Retry"),
        ("SubTree", "write Subtree"),
    ] {
        let node =
            format!(r#"{{"id": "r", "type": "{name}", "children": [{{"id": "a", {WAIT}}}]}}"#);
        let text = format!(r#"{{"format": "behavior-tree/1", "name": "t", "root": {node}}}"#);
        let wrong = descriptor_common::read(&text).err().unwrap().to_string();
        let wanted = format!("unknown node type '{name}'; ");
        assert!(wrong.contains(&wanted) && wrong.contains(ours), "{wrong}");
    }
}
