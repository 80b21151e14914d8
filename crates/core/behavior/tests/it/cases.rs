//! Cases made from the two reference libraries, as the conformance example
//! runs them; a few hundred of them for every build.

use crate::machine;
use crate::tree;

use serde_json::{Value, json};

fn cases(kind: &str) -> Vec<Value> {
    let all = include_str!("../cases.jsonl")
        .lines()
        .map(serde_json::from_str::<Value>);
    all.map(Result::unwrap)
        .filter(|case| case["kind"] == kind)
        .collect()
}

#[test]
fn trees_do_what_the_reference_does() {
    let cases = cases("tree");
    assert_eq!(cases.len(), 240);
    for case in cases {
        assert_eq!(tree::run(&case), Ok(()));
    }
}

#[test]
fn machines_do_what_the_reference_does() {
    let cases = cases("machine");
    assert_eq!(cases.len(), 120);
    for case in cases {
        assert_eq!(machine::run(&case), Ok(()));
    }
}

#[test]
fn a_tree_that_does_something_else_is_noticed() {
    let mut case = cases("tree").swap_remove(0);
    case["ticks"][0]["root"] = json!("-");
    let message = tree::run(&case).unwrap_err();
    assert!(message.contains("tick 0: root is "), "{message}");
    for count in ["initialise", "update", "stopped"] {
        let mut case = cases("tree").swap_remove(0);
        let counts = case["counts"].as_object_mut().unwrap();
        let first = counts.values_mut().next().unwrap();
        first[count] = json!(1000);
        assert!(tree::run(&case).unwrap_err().contains(count));
    }
}
