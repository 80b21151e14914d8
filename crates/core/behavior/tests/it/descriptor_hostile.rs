//! Files made to do harm: each is refused with a place, soon and within
//! bounded memory, and nothing panics.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::too_many_lines,
    reason = "in tests"
)]

use crate::descriptor_common;

use std::collections::BTreeMap;
use std::fmt::Write;

use behavior::board::Board;
use behavior::descriptor::{self, Source, json};
use behavior::tree::MAX_NODES;
use descriptor_common::{GOOD, library, read, read_with};
use proptest::prelude::*;

fn file(rest: &str) -> String {
    format!(r#"{{"format": "behavior-tree/1", "name": "t", {rest}}}"#)
}

/// The file is refused, and every message starts with its place.
fn refusal(text: &str) -> String {
    let errors = read(text).err().unwrap_or_else(|| panic!("accepted"));
    for located in &errors.list {
        assert!(located.line >= 1 && located.column >= 1, "{located}");
        assert!(located.message.len() < 4000, "{}", located.message.len());
        assert!(!located.message.contains(['\n', '\u{1b}']), "{located}");
    }
    assert!(!errors.list.is_empty());
    assert!(errors.list.len() <= 100);
    errors.to_string()
}

const WAIT: &str = r#""type": "Wait", "ports": {"seconds": 1}"#;

#[test]
fn a_hundred_thousand_nodes() {
    let mut children = String::new();
    for i in 0..100_000 {
        let comma = if i > 0 { ",\n" } else { "" };
        write!(
            children,
            "{comma}{{\"id\": \"{i}\", \"type\": \"Sequence\"}}"
        )
        .unwrap();
    }
    let text = file(&format!(
        r#""root": {{"id": "r", "type": "Selector", "children": [{children}]}}"#
    ));
    let wrong = refusal(&text);
    assert!(
        wrong.starts_with(&format!(
            "t.json:{MAX_NODES}:1: the tree has more than 16384"
        )),
        "{wrong}"
    );
    assert_eq!(wrong.lines().count(), 1);
}

#[test]
fn a_tree_as_deep_as_it_may_be_and_one_deeper() {
    let nested = |depth: usize| {
        let mut node = format!(r#"{{"id": "w", {WAIT}}}"#);
        for i in 0..depth {
            node = format!(r#"{{"id": "n{i}", "type": "Inverter", "children": [{node}]}}"#);
        }
        file(&format!(r#""root": {node}"#))
    };
    assert!(read(&nested(60)).is_ok());
    // JSON's own depth is reached first: two levels a node.
    assert!(refusal(&nested(64)).contains("nested deeper than"));
    assert!(refusal(&nested(50_000)).contains("deeper than 128"));
}

#[test]
fn depth_by_modifiers_and_subtrees() {
    let many = vec![r#"{"type": "InvertStatus"}"#; 64].join(", ");
    let text = file(&format!(
        r#""root": {{"id": "r", {WAIT}, "modifiers": [{many}]}}"#
    ));
    assert!(refusal(&text).contains("nested deeper than 64 levels"));
    let mut subtrees = vec![format!(r#""s0": {{"root": {{"id": "w", {WAIT}}}}}"#)];
    for i in 1..100 {
        let below = i - 1;
        subtrees.push(format!(
            r#""s{i}": {{"root": {{"id": "u", "type": "Subtree", "subtree": "s{below}"}}}}"#
        ));
    }
    let subtrees = subtrees.join(", ");
    let text = file(&format!(
        r#""subtrees": {{{subtrees}}}, "root": {{"id": "r", "type": "Subtree", "subtree": "s99"}}"#
    ));
    assert!(refusal(&text).contains("nested deeper than 64 levels"));
}

#[test]
fn subtrees_that_multiply() {
    let mut subtrees = vec![format!(r#""s0": {{"root": {{"id": "w", {WAIT}}}}}"#)];
    for i in 1..25 {
        let uses: Vec<String> = (0..10)
            .map(|n| {
                format!(
                    r#"{{"id": "u{n}", "type": "Subtree", "subtree": "s{}"}}"#,
                    i - 1
                )
            })
            .collect();
        let uses = uses.join(", ");
        subtrees.push(format!(
            r#""s{i}": {{"root": {{"id": "all", "type": "Sequence", "children": [{uses}]}}}}"#
        ));
    }
    let subtrees = subtrees.join(",\n");
    let text = file(&format!(
        r#""subtrees": {{{subtrees}}}, "root": {{"id": "r", "type": "Subtree", "subtree": "s24"}}"#
    ));
    let wrong = refusal(&text);
    assert!(wrong.contains("more than 16384 nodes"), "{wrong}");
}

#[test]
fn circles() {
    let text = file(
        r#""subtrees": {"a": {"root": {"id": "x", "type": "Subtree", "subtree": "b"}},
        "b": {"root": {"id": "y", "type": "Inverter", "children": [{"id": "z", "type": "Subtree", "subtree": "a"}]}}},
        "root": {"id": "r", "type": "Subtree", "subtree": "a"}"#,
    );
    assert!(refusal(&text).contains("t.json:2:110: a subtree is part of itself: a -> b -> a"));
    let text = file(r#""includes": ["t.json"], "root": {}"#);
    assert!(refusal(&text).contains("files include each other: t.json -> t.json"));
    let endless = |name: &str| {
        let next = name.parse::<u32>().unwrap_or(0) + 1;
        Ok(format!(
            r#"{{"format": "behavior-tree/1", "includes": ["{next}"]}}"#
        ))
    };
    let text = file(r#""includes": ["1"], "root": {}"#);
    let wrong = read_with(&text, &BTreeMap::new(), &endless).err().unwrap();
    assert!(wrong.to_string().contains("more than 32 files"), "{wrong}");
}

#[test]
fn very_long_names_and_very_many_of_them() {
    let long = "x".repeat(1_000_000);
    for text in [
        file(&format!(r#""root": {{"id": "{long}", {WAIT}}}"#)),
        file(&format!(r#""root": {{"id": "r", "type": "{long}"}}"#)),
        file(&format!(r#""root": {{"id": "r", "{long}": 1, {WAIT}}}"#)),
        file(&format!(
            r#""root": {{"id": "r", "type": "Wait", "ports": {{"{long}": 1}}}}"#
        )),
        file(&format!(
            r#""constants": {{"{long}": 1}}, "root": {{"id": "r", {WAIT}}}"#
        )),
        file(&format!(
            r#""constants": {{"a": "{long}"}}, "root": {{"id": "r", {WAIT}}}"#
        )),
        file(&format!(
            r#""root": {{"id": "r", "type": "Wait", "ports": {{"seconds": "{long}"}}}}"#
        )),
        file(&format!(
            r#""root": {{"id": "r", "type": "Wait", "ports": {{"seconds": "${{{long}}}"}}}}"#
        )),
        file(&format!(
            r#""root": {{"id": "r", "type": "Wait", "ports": {{"seconds": {{"bb": "local.{long}"}}}}}}"#
        )),
        file(&format!(
            r#""root": {{"id": "r", "name": "a\u001b[2J\n{long}", {WAIT}}}"#
        )),
    ] {
        refusal(&text);
    }
    let mut keys = String::new();
    for i in 0..100_000 {
        write!(keys, "\"k{i}\": 1, ").unwrap();
    }
    let text = file(&format!(r#""root": {{"id": "r", {keys} {WAIT}}}"#));
    assert!(refusal(&text).ends_with("more"));
    let text = file(&format!(
        r#""constants": {{{keys} "a": 1}}, "root": {{"id": "r", {WAIT}}}"#
    ));
    assert!(refusal(&text).contains("at most 512 are allowed"));
    let text = file(&format!(
        r#""root": {{"id": "r", "type": "Wait", "ports": {{{keys} "a": 1}}}}"#
    ));
    assert!(refusal(&text).contains("at most 64 are allowed"));
}

#[test]
fn numbers_that_are_none() {
    for number in [
        "NaN",
        "Infinity",
        "-Infinity",
        "1e999",
        "-1e999",
        "0x10",
        "1e",
        "--1",
        "01",
    ] {
        let text = file(&format!(
            r#""root": {{"id": "r", "type": "Wait", "ports": {{"seconds": {number}}}}}"#
        ));
        let read = read(&text);
        assert!(read.is_err() || number == "01", "{number}");
    }
    let text = file(r#""root": {"id": "r", "type": "Wait", "ports": {"seconds": 1e308}}"#);
    assert!(read(&text).is_ok());
}

#[test]
fn a_refused_file_leaves_the_shared_board_alone() {
    let mut shared = Board::new();
    let text = GOOD.replace("\"IsSeen\"", "\"IsSen\"");
    let source = Source {
        file: "t.json",
        text: &text,
        include: &|_| Err(String::new()),
    };
    assert!(descriptor::load(&source, &library(), &BTreeMap::new(), &mut shared).is_err());
    assert_eq!(shared.keys().count(), 0);
    let source = Source {
        file: "t.json",
        text: GOOD,
        include: &|_| Err(String::new()),
    };
    assert!(descriptor::load(&source, &library(), &BTreeMap::new(), &mut shared).is_ok());
    assert_eq!(shared.keys().count(), 2);
}

/// Loading never panics; an accepted file can be checked.
fn survives(text: &str) {
    match read(text) {
        Ok(_) => {
            let source = Source {
                file: "t.json",
                text,
                include: &|_| Err(String::new()),
            };
            let mut shared = Board::new();
            let loaded = descriptor::load(&source, &library(), &BTreeMap::new(), &mut shared);
            assert!(
                loaded.is_ok(),
                "the tree of a file that was read is refused"
            );
            let found = descriptor::check(&source, &library(), &BTreeMap::new(), &Board::new());
            assert!(found.is_ok());
        }
        Err(errors) => {
            assert!(!errors.is_empty());
            assert!(errors.list.iter().all(|e| e.file == "t.json" && e.line > 0));
        }
    }
}

/// Random JSON out of the words of the format.
fn any_json() -> impl Strategy<Value = String> {
    const WORDS: &[&str] = &[
        "id",
        "type",
        "ports",
        "children",
        "modifiers",
        "root",
        "subtrees",
        "constants",
        "blackboard",
        "local",
        "shared",
        "bb",
        "port",
        "local.k",
        "shared.k",
        "Sequence",
        "Selector",
        "Parallel",
        "Subtree",
        "EternalGuard",
        "guard",
        "subtree",
        "Wait",
        "seconds",
        "MoveTo",
        "target",
        "a",
        "CheckBlackboard",
        "equals",
        "key",
        "k",
        "text",
        "number",
        "default",
        "${a}",
        "${",
        "",
        "format",
        "behavior-tree/1",
        "name",
        "includes",
        "abort",
        "both",
        "count",
        "policy",
        "selected",
    ];
    let word = proptest::sample::select(WORDS).prop_map(|w| format!("\"{w}\""));
    let leaf = prop_oneof![
        Just("null".to_owned()),
        any::<bool>().prop_map(|b| b.to_string()),
        any::<i64>().prop_map(|i| i.to_string()),
        (-1e3..1e3).prop_map(|n: f64| n.to_string()),
        word.clone(),
    ];
    leaf.prop_recursive(6, 64, 6, move |inner| {
        prop_oneof![
            proptest::collection::vec(inner.clone(), 0..5)
                .prop_map(|v| format!("[{}]", v.join(","))),
            proptest::collection::vec((word.clone(), inner), 0..6).prop_map(|entries| {
                let entries: Vec<String> =
                    entries.iter().map(|(k, v)| format!("{k}:{v}")).collect();
                format!("{{{}}}", entries.join(","))
            }),
        ]
    })
}

/// A part of the good file, as bytes, with something done to it.
fn mutated() -> impl Strategy<Value = String> {
    let places =
        proptest::collection::vec((0..GOOD.len(), any::<u8>(), 0..4_u8, 1..40_usize), 1..4);
    places.prop_map(|changes| {
        let mut bytes = GOOD.as_bytes().to_vec();
        for (at, byte, what, length) in changes {
            let at = at.min(bytes.len().saturating_sub(1));
            let end = (at + length).min(bytes.len());
            match what {
                // The changes before this one may have left nothing.
                0 => drop(bytes.get_mut(at).map(|changed| *changed ^= byte)),
                1 => drop(bytes.drain(at..end)),
                2 => bytes.truncate(at.max(1)),
                _ => {
                    let copy = bytes[at..end].to_vec();
                    let to = usize::from(byte) * bytes.len() / 256;
                    bytes.splice(to..to, copy);
                }
            }
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_file_is_read_or_refused(text in mutated()) {
        survives(&text);
    }

    #[test]
    fn any_json_is_read_or_refused(node in any_json(), extra in any_json()) {
        survives(&node);
        survives(&file(&format!(r#""subtrees": {{"a": {{"root": {extra}}}}}, "root": {node}"#)));
        survives(&file(&format!(r#""constants": {extra}, "blackboard": {{"local": {node}}}, "root": {extra}"#)));
    }

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,200}") {
        if let Err(errors) = json::parse("f", &text) {
            prop_assert!(!errors.is_empty());
        }
    }

    #[test]
    fn one_value_in_the_place_of_another_is_read_or_refused(
        nth in 0..400_usize, value in any_json(),
    ) {
        // Replaces the nth value of the good file, found by its colon.
        let colons: Vec<usize> = GOOD.match_indices(": ").map(|(i, _)| i + 2).collect();
        let start = colons[nth % colons.len()];
        let end = GOOD[start..].find([',', '}', ']', '\n']).map_or(GOOD.len(), |i| start + i);
        survives(&format!("{}{value}{}", &GOOD[..start], &GOOD[end..]));
    }
}
