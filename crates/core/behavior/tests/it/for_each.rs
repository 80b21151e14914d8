//! `ForEach`: a tree with it is the tree with the copies written out.

#![allow(clippy::unwrap_used, clippy::panic, reason = "in tests")]

use crate::descriptor_common;

use std::collections::BTreeMap;
use std::time::Duration;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::{Memory, Node, Tree};
use behavior::views;
use descriptor_common::{Toy, library, read};

fn file(root: &str) -> String {
    format!(
        r#"{{"format": "behavior-tree/1", "name": "t", "constants": {{"far": 2.0}}, "root": {root}}}"#
    )
}

/// Moves to `${x}`, and waits.
const BODY: &str = r#"{"id": "bring", "type": "Sequence", "children": [
    {"id": "go", "type": "MoveTo", "ports": {"target": [0.0, 0.0, 1.0], "speed": "${x}"}},
    {"id": "rest", "name": "rest of ${x}", "type": "Wait", "ports": {"seconds": 0.0}}]}"#;

fn for_each(items: &str) -> String {
    format!(
        r#"{{"id": "all", "type": "ForEach", "as": "x", "items": {items}, "children": [{BODY}]}}"#
    )
}

fn ids(node: &Node<Toy>, out: &mut Vec<String>) {
    out.push(node.id.clone());
    node.children.iter().for_each(|child| ids(child, out));
}

fn ids_of(root: &str) -> Vec<String> {
    let read = read(&file(root)).unwrap_or_else(|errors| panic!("{errors}"));
    let mut all = Vec::new();
    ids(&read.root, &mut all);
    all
}

fn tree(root: &str) -> Tree<Toy> {
    let text = file(root);
    let source = Source {
        file: "t.json",
        text: &text,
        include: &|_| Err(String::new()),
    };
    let (library, mut shared) = (library(), Board::new());
    descriptor::load(&source, &library, &BTreeMap::new(), &mut shared)
        .unwrap_or_else(|errors| panic!("{errors}"))
}

/// Ticks until it is finished; what its leaves did.
fn run(tree: &mut Tree<Toy>, ticks: u64) -> Vec<String> {
    let (mut log, mut shared) = (Vec::new(), Board::new());
    for tick in 0..ticks {
        let status = tree.tick(Duration::from_millis(tick), &mut shared, &mut log);
        log.push(format!("{status:?}"));
    }
    log
}

#[test]
fn each_copy_has_its_item_in_its_ports_names_and_ids() {
    let read = read(&file(&for_each("[0.25, 1, \"${far}\"]"))).unwrap_or_else(|e| panic!("{e}"));
    let mut all = Vec::new();
    ids(&read.root, &mut all);
    assert_eq!(
        all,
        [
            "all",
            "bring[0.25]",
            "go[0.25]",
            "rest[0.25]",
            "bring[1]",
            "go[1]",
            "rest[1]",
            "bring[2]",
            "go[2]",
            "rest[2]",
        ]
    );
    let second = &read.root.children[1];
    assert_eq!(
        (second.name.as_str(), second.children[1].name.as_str()),
        ("bring[1]", "rest of 1")
    );
    assert_eq!(read.findings, []);
    let drawn = views::text(&tree(&for_each("[0.5, 1.5]")).graph(), None);
    assert!(
        drawn.contains("→ all (ForEach)  x in [0.5, 1.5]"),
        "{drawn}"
    );
}

#[test]
fn it_does_what_the_copies_do_and_continues_by_item() {
    let copy = |x: &str| {
        BODY.replace("\"${x}\"", x)
            .replace("${x}", x)
            .replace("\"bring\"", &format!("\"bring[{x}]\""))
            .replace("\"go\"", &format!("\"go[{x}]\""))
            .replace("\"rest\"", &format!("\"rest[{x}]\""))
    };
    let copies = format!(
        r#"{{"id": "all", "type": "Sequence", "children": [{}, {}, {}]}}"#,
        copy("0.5"),
        copy("1.5"),
        copy("1")
    );
    let (mut one, mut other) = (tree(&for_each("[0.5, 1.5, 1]")), tree(&copies));
    assert_eq!(run(&mut one, 2), run(&mut other, 2));
    let mut record = Vec::new();
    one.save(&mut record);
    // The checkpoint of one is that of the other, and of an edited list.
    let mut edited = tree(&for_each("[2, 0.5, 1.5]"));
    for tree in [&mut other, &mut edited] {
        tree.restore(&record).unwrap();
        let log = run(tree, 1);
        assert_eq!(log[0], "move [0.0, 0.0, 1.0] 1.5");
    }
}

#[test]
fn loops_nest_and_the_outer_item_comes_first() {
    let inner = r#"{"id": "in", "type": "ForEach", "as": "y", "items": ["a", "b"], "children": [
        {"type": "IsSeen", "id": "see", "name": "${x}_${y}", "ports": {"thing": "red"}}]}"#;
    let outer = format!(
        r#"{{"id": "out", "type": "ForEach", "as": "x", "items": ["p", "q"], "children": [{inner}]}}"#
    );
    let of_file = ids_of(&outer);
    assert_eq!(
        of_file,
        [
            "out",
            "in[p]",
            "see[p][a]",
            "see[p][b]",
            "in[q]",
            "see[q][a]",
            "see[q][b]"
        ]
    );
    let in_code: Node<Toy> = Node::for_each("out", Memory::Yes, ["p", "q"], |_| {
        Node::for_each("in", Memory::Yes, ["a", "b"], |_| {
            Node::sequence("see", Memory::Yes, Vec::new())
        })
    });
    let mut all = Vec::new();
    ids(&in_code, &mut all);
    assert_eq!(all, of_file);
    assert_eq!(in_code.children[1].children[0].name, "see[q][a]");
}

#[test]
fn parts_of_a_subtree_and_nodes_without_an_id_are_told_apart() {
    let text = r#"{"format": "behavior-tree/1", "name": "t",
        "subtrees": {"go": {"ports": {"speed": {"type": "number"}},
            "root": {"id": "move", "type": "MoveTo",
                "ports": {"target": [0, 0, 1], "speed": {"port": "speed"}}}}},
        "root": {"id": "all", "type": "ForEach", "as": "x", "items": [1, 2], "children": [
            {"type": "Sequence", "children": [
                {"id": "use", "type": "Subtree", "subtree": "go", "ports": {"speed": "${x}"}}]}]}}"#;
    let read = read(text).unwrap_or_else(|errors| panic!("{errors}"));
    let mut all = Vec::new();
    ids(&read.root, &mut all);
    let first = ["all/0:Sequence[1]", "use[1]", "use[1]/move[1]"];
    assert_eq!(all[1..4], first);
    assert_eq!(all.len(), 7);
}

#[test]
fn what_is_wrong_is_named() {
    let good = for_each("[1, 2]");
    let many: Vec<String> = (0..6000).map(|n| format!("0.{n:04}")).collect();
    let many = format!("[{}]", many.join(", "));
    for (from, to, wanted) in [
        (
            "\"as\": \"x\"",
            "\"as\": \"far\"",
            "'far' is the name of a constant",
        ),
        ("\"as\": \"x\"", "\"as\": \"a b\"", "without spaces"),
        ("\"as\": \"x\", ", "", "\"as\" is missing; ForEach needs it"),
        ("\"items\": [1, 2], ", "", "\"items\" is missing"),
        (
            "[1, 2]",
            "3",
            "a list of items is needed here, this is the integer 3",
        ),
        ("[1, 2]", "[1, \"1\"]", "item '1' is defined twice"),
        ("[1, 2]", "[\"a b\"]", "this is the text 'a b'"),
        ("[1, 2]", "[\"${near}\"]", "unknown constant 'near'"),
        ("[1, 2]", &many, "items of ForEach counted"),
        (
            BODY,
            &format!("{BODY}, {BODY}"),
            "ForEach needs exactly one child, here are 2",
        ),
        (
            BODY,
            &good,
            "or of an item of another ForEach around this one",
        ),
        (
            "\"ForEach\"",
            "\"Sequence\"",
            "only ForEach has 'as', this is Sequence",
        ),
    ] {
        assert!(good.contains(from), "{from}");
        let errors = read(&file(&good.replacen(from, to, 1))).err().unwrap();
        assert!(errors.to_string().contains(wanted), "{wanted}\n{errors}");
    }
    let unused = good.replace("\"${x}\"", "1").replace(" of ${x}", "");
    let findings = read(&file(&unused)).map(|read| read.findings).unwrap();
    assert_eq!(findings[0].rule, "unused_item");
}
