//! Leaves that answer without being run.

use std::time::Duration;

use behavior::board::Board;
use behavior::status::Status;
use behavior::tree::{Memory, Node, Replacement};

use crate::tree_support::{Stand, act};

fn from(answer: Status, from_ms: u64, until_ms: Option<u64>) -> Replacement {
    Replacement {
        answer,
        from: Duration::from_millis(from_ms),
        until: until_ms.map(Duration::from_millis),
    }
}

fn stand(replacements: Vec<Replacement>) -> Stand {
    let root = Node::sequence("root", Memory::Yes, vec![act("a", "S"), act("b", "R")]);
    let mut stand = Stand::new(root, Board::new());
    if !replacements.is_empty() {
        stand.tree.replace("b", replacements).unwrap();
    }
    stand
}

#[test]
fn a_replaced_leaf_answers_and_is_not_run() {
    let mut stand = stand(vec![from(Status::Success, 0, None)]);
    assert_eq!(stand.tick(0), ('S', "a starts, a S".to_owned()));
    assert_eq!(stand.tick(1), ('S', "a starts, a S".to_owned()));
}

#[test]
fn a_leaf_that_runs_is_stopped_and_starts_again() {
    let rules = || {
        vec![
            from(Status::Running, 10, Some(30)),
            from(Status::Failure, 50, Some(60)),
        ]
    };
    let run = |kills: bool| {
        let mut stand = stand(rules());
        let mut told = Vec::new();
        for ms in [0, 10, 20, 30, 40, 50, 60] {
            told.push(stand_tick(&mut stand, ms));
            if kills {
                stand.kill(|| self::stand(rules()));
            }
        }
        told
    };
    let expected = [
        "R a starts, a S, b starts, b R",
        "R b halts: reset",
        "R ",
        "R b starts, b R",
        "R b R",
        "F b halts: reset",
        "R a starts, a S, b starts, b R",
    ];
    assert_eq!(run(false), expected);
    assert_eq!(run(true), expected, "killed after every tick");
}

fn stand_tick(stand: &mut Stand, ms: u64) -> String {
    let (answer, told) = stand.tick(ms);
    format!("{answer} {told}")
}

#[test]
fn without_a_rule_that_applies_nothing_differs() {
    let mut plain = stand(Vec::new());
    let mut later = stand(vec![from(Status::Failure, 1_000, None)]);
    for ms in [0, 10, 20] {
        assert_eq!(plain.tick(ms), later.tick(ms));
        assert_eq!(plain.letters(), later.letters());
    }
}

#[test]
fn only_leaves_are_replaced() {
    let mut stand = stand(Vec::new());
    let unknown = stand
        .tree
        .replace("bb", Vec::new())
        .unwrap_err()
        .to_string();
    assert!(unknown.contains("unknown leaf 'bb'; "), "{unknown}");
    let root = stand
        .tree
        .replace("root", Vec::new())
        .unwrap_err()
        .to_string();
    assert!(
        root.contains("'root' is a sequence, only leaves are replaced"),
        "{root}"
    );
}
