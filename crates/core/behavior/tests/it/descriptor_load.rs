//! What a file means, and what its author is told when it is wrong.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::too_many_lines,
    reason = "in tests"
)]

use crate::descriptor_common;

use std::collections::BTreeMap;
use std::time::Duration;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use behavior::tree::{Node, Tree};
use behavior::value::Set;
use behavior::{NodeStatus, Status, Str, Value, views};
use descriptor_common::{GOOD, Toy, library, read, read_with};

fn find<'n>(node: &'n Node<Toy>, id: &str) -> Option<&'n Node<Toy>> {
    if node.id == id {
        return Some(node);
    }
    node.children.iter().find_map(|child| find(child, id))
}

fn value(board: &Board, key: &str) -> Option<Value> {
    board.value(board.index(key)?)
}

#[test]
fn a_good_file_is_read_whole() {
    let read = read(GOOD).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(read.name, "demo left");
    assert_eq!(read.root.name, "Root of left");
    assert_eq!(value(&read.local, "patience"), Some(Value::Number(5.0)));
    assert!(value(&read.shared, "stop:left").is_some());
    let there = find(&read.root, "there/move").unwrap();
    assert_eq!(there.type_name, "MoveTo");
    assert!(find(&read.root, "back/rest").is_some());
    let stopped = find(&read.root, "stopped").unwrap();
    assert_eq!(stopped.modifiers.len(), 2);
    assert_eq!(there.detail, "target=to speed=0.25");
    assert_eq!(read.findings, []);
}

#[test]
fn constants_of_the_instance_replace_those_of_the_file() {
    let right = Value::Text(Str::new("right").unwrap());
    let constants = BTreeMap::from([("arm".to_owned(), right)]);
    let read =
        read_with(GOOD, &constants, &|_| Err(String::new())).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(read.name, "demo right");
    assert!(value(&read.shared, "stop:left").is_none());
    let constants = BTreeMap::from([("arm".to_owned(), Value::Integer(1))]);
    let wrong = read_with(GOOD, &constants, &|_| Err(String::new()))
        .err()
        .unwrap();
    assert!(
        wrong
            .to_string()
            .contains("t.json:5:24: constant 'arm' is text"),
        "{wrong}"
    );
}

/// `change` made to the good file gives exactly these messages.
fn refused(change: (&str, &str), wanted: &[&str]) {
    assert!(GOOD.contains(change.0), "{}", change.0);
    let text = GOOD.replacen(change.0, change.1, 1);
    let errors = read(&text)
        .err()
        .unwrap_or_else(|| panic!("accepted: {}", change.1));
    let found: Vec<String> = errors.list.iter().map(ToString::to_string).collect();
    assert_eq!(found.len(), wanted.len(), "{errors}");
    for (found, wanted) in found.iter().zip(wanted) {
        assert!(found.contains(wanted), "{found}\ndoes not say\n{wanted}");
    }
}

#[test]
fn each_mistake_is_named_with_its_place() {
    let cases: &[((&str, &str), &str)] = &[
        (
            ("behavior-tree/1", "behavior-tree/9"),
            "t.json:2:13: this version reads the format 'behavior-tree/1'",
        ),
        (
            ("\"PickNext\"", "\"PickNxt\""),
            "t.json:44:34: unknown node type 'PickNxt'; did you mean 'PickNext'?",
        ),
        (
            ("\"PickNext\"", "\"choose\""),
            "did you mean 'PickNext' (choose)?",
        ),
        (
            ("\"Selector\"", "\"fallback\""),
            "did you mean 'Selector' (fallback)?",
        ),
        (
            (
                "\"children\": [{\"id\": \"still\"",
                "\"childs\": [{\"id\": \"still\"",
            ),
            "unknown key 'childs'; did you mean 'children'?",
        ),
        (("\"lower_priority\"", "\"lower\""), "abort mode 'lower'"),
        (
            ("shared.stop:${arm}", "shared.stopp:${arm}"),
            "did you mean 'stop:left'?",
        ),
        (
            ("shared.stop:${arm}", "shared.stop:${hand}"),
            "unknown constant 'hand'",
        ),
        (
            ("shared.stop:${arm}", "shared.stop:${arm"),
            "'${' without '}'",
        ),
        (
            ("shared.stop:${arm}", "share.stop"),
            "unknown blackboard 'share'; did you mean 'shared'?",
        ),
        (
            ("\"equals\": true", "\"equals\": 3"),
            "the key is of type bool, it is compared with 3",
        ),
        (
            ("\"equals\": true", "\"above\": 3"),
            "'above' is for numbers, the key is of type bool",
        ),
        (
            ("\"equals\": true", "\"equals\": true, \"set\": true"),
            "one test is enough",
        ),
        (
            ("{\"bb\": \"local.patience\"}", "{\"bb\": \"local.thing\"}"),
            "'thing' is of type text, the port needs number",
        ),
        (
            ("\"seconds\": 1}", "\"seconds\": -1}"),
            "port 'seconds' is -1 s, 0 or more is needed",
        ),
        (
            ("\"seconds\": 1}", "\"seconds\": 1e999}"),
            "1e999 is not a finite number",
        ),
        (
            ("\"seconds\": 1}", "\"seconds\": \"one\"}"),
            "a number is needed here, this is the text 'one'",
        ),
        (
            ("\"seconds\": 1}", "\"second\": 1}"),
            "unknown port 'second'; did you mean 'seconds'?",
        ),
        (
            (
                "{\"thing\": {\"bb\": \"local.thing\"}}},\n          {\"id\": \"guarded\"",
                "{\"thing\": \"red\"}},\n          {\"id\": \"guarded\"",
            ),
            "port 'thing' is written; bind it to a key",
        ),
        (
            (
                "{\"type\": \"IsSeen\", \"ports\": {\"thing\": {\"bb\": \"local.thing\"}}}",
                "{\"type\": \"IsSeen\", \"ports\": {\"thing\": \"rad\"}}",
            ),
            "port 'thing' cannot be 'rad'; did you mean 'red'?",
        ),
        (
            (
                "{\"type\": \"IsSeen\", \"ports\": {\"thing\": {\"bb\": \"local.thing\"}}}",
                "{\"type\": \"Wait\", \"ports\": {\"seconds\": 1}}",
            ),
            "Wait cannot be a guard",
        ),
        (
            (
                "{\"type\": \"IsSeen\", \"ports\": {\"thing\": {\"bb\": \"local.thing\"}}}",
                "{\"type\": \"IsSeen\"}",
            ),
            "IsSeen needs the port 'thing'",
        ),
        (
            ("\"slow\": 0.25", "\"slow\": 2.5"),
            "port 'speed' is 2.5, allowed is 0 to 2",
        ),
        (
            ("\"to\": [0, 0, 1]", "\"to\": [0, 1]"),
            "MoveTo: port 'target' is [0.0, 1.0]",
        ),
        (
            (
                "\"subtree\": \"go\", \"ports\": {\"to\": {\"bb\": \"local.place\"}}",
                "\"subtree\": \"goo\"",
            ),
            "unknown subtree 'goo'; did you mean 'go'?",
        ),
        (
            (
                "\"subtree\": \"go\", \"ports\": {\"to\": {\"bb\": \"local.place\"}}",
                "\"subtree\": \"go\"",
            ),
            "subtree 'go' needs the port 'to'",
        ),
        (
            ("{\"port\": \"to\"}", "{\"port\": \"too\"}"),
            "unknown port of this subtree 'too'; did you mean 'to'?",
        ),
        (
            ("\"selected\": [\"note\"]", "\"selected\": [\"nota\"]"),
            "unknown child of this node 'nota'; did you mean 'note'?",
        ),
        (
            ("\"policy\": \"selected\"", "\"policy\": \"all\""),
            "belong together",
        ),
        (
            ("\"value\": [1, 2, 3]", "\"value\": [1, 2, 64]"),
            "the key is of type set",
        ),
        (
            ("\"count\": \"${times}\"", "\"count\": 0"),
            "port 'count' is 0, 1 to",
        ),
        (
            (
                "\"count\": \"${times}\"",
                "\"count\": {\"bb\": \"local.tries\"}",
            ),
            "has to be a value that is known when the file is loaded",
        ),
        (
            ("\"id\": \"pick\"", "\"id\": \"work\""),
            "id 'work' is used in t.json:43",
        ),
        (
            ("\"id\": \"pick\"", "\"id\": \"a/b\""),
            "without spaces and '/'",
        ),
        (
            ("\"default\": 0}", "\"default\": \"0\"}"),
            "an integer is needed here, this is the text '0'",
        ),
        (
            ("\"type\": \"bool\"", "\"type\": \"boolean\""),
            "unknown type of value 'boolean'; did you mean 'bool'?",
        ),
        (
            (
                "[{\"id\": \"still\", \"type\": \"Wait\", \"ports\": {\"seconds\": 1}}]",
                "[]",
            ),
            "SuccessIsRunning needs exactly one child, here are 0",
        ),
        (
            (
                "\"type\": \"PickNext\"",
                "\"type\": \"PickNext\", \"children\": [{\"id\": \"x\", \"type\": \"Wait\", \"ports\": {\"seconds\": 1}}]",
            ),
            "PickNext has no children, here are 1",
        ),
        (
            (
                "\"type\": \"PickNext\"",
                "\"type\": \"PickNext\", \"guard\": {}",
            ),
            "only EternalGuard has 'guard'",
        ),
        (
            ("\"blackboard\"", "\"include\": [], \"blackboard\""),
            "unknown key 'include'; did you mean 'includes'?",
        ),
        (
            ("\"blackboard\"", "\"name\": \"x\", \"blackboard\""),
            "key 'name' is given twice",
        ),
    ];
    for (change, wanted) in cases {
        let text = GOOD.replacen(change.0, change.1, 1);
        assert!(GOOD.contains(change.0), "{}", change.0);
        let errors = read(&text)
            .err()
            .unwrap_or_else(|| panic!("accepted: {}", change.1));
        assert!(
            errors.to_string().contains(wanted),
            "{errors}\ndoes not say\n{wanted}"
        );
        assert!(errors.to_string().starts_with("t.json:"), "{errors}");
    }
}

#[test]
fn all_mistakes_of_a_file_are_named_at_once() {
    let mistakes = "\"PickNxt\", \"doc\": 1, \"port\": {}";
    refused(
        ("\"PickNext\"", mistakes),
        &[
            "t.json:44:34: unknown node type",
            "t.json:44:55: in a node: unknown key 'port'",
        ],
    );
    let text = GOOD
        .replace("local.patience", "local.patients")
        .replace("\"MoveTo\"", "\"MoveToo\"")
        .replace("\"seconds\": 1}", "\"seconds\": true}");
    let errors = read(&text).err().unwrap();
    assert_eq!(errors.list.len(), 3, "{errors}");
}

#[test]
fn a_used_name_of_older_files_is_found() {
    let read = read(&GOOD.replace("\"MoveTo\"", "\"Goto\"")).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(find(&read.root, "there/move").unwrap().type_name, "MoveTo");
}

#[test]
fn included_files_bring_subtrees_keys_and_constants() {
    let text = r#"{"format": "behavior-tree/1", "name": "a", "includes": ["b"],
        "root": {"id": "r", "type": "Subtree", "subtree": "s"}}"#;
    let b = r#"{"format": "behavior-tree/1", "includes": ["c"], "subtrees": {"s": {"root":
        {"id": "w", "type": "Wait", "ports": {"seconds": "${long}"}}}}}"#;
    let c = r#"{"format": "behavior-tree/1", "constants": {"long": 7.5}}"#;
    let files = |c: &'static str| {
        move |name: &str| match name {
            "b" => Ok(b.to_owned()),
            "c" => Ok(c.to_owned()),
            _ => Err("it is UTF-16 text".to_owned()),
        }
    };
    let read = read_with(text, &BTreeMap::new(), &files(c)).unwrap_or_else(|e| panic!("{e}"));
    assert!(find(&read.root, "r/w").is_some());
    let circle = r#"{"format": "behavior-tree/1", "includes": ["b"]}"#;
    let wrong = read_with(text, &BTreeMap::new(), &files(circle))
        .err()
        .unwrap();
    assert!(
        wrong
            .to_string()
            .starts_with("c:1:44: files include each other: t.json -> b -> c -> b"),
        "{wrong}"
    );
    let wrong = read_with(text, &BTreeMap::new(), &files("{\"format\": 1,}"))
        .err()
        .unwrap();
    assert!(wrong.to_string().starts_with("c:1:1"), "{wrong}");
    let wrong = read_with(&text.replace("\"b\"", "\"x\""), &BTreeMap::new(), &files(c))
        .err()
        .unwrap();
    assert!(
        wrong
            .to_string()
            .starts_with("t.json:1:57: the file 'x' cannot be read: it is UTF-16 text; "),
        "{wrong}"
    );
}

#[test]
fn what_is_declared_for_nothing_is_found() {
    let text = GOOD
        .replace("\"slow\": 0.25", "\"slow\": 0.25, \"spare\": 1")
        .replace(
            "\"tries\": {",
            "\"spare\": {\"type\": \"bool\"}, \"tries\": {",
        )
        .replace("\"id\": \"pick\", ", "");
    let read = read(&text).unwrap_or_else(|e| panic!("{e}"));
    let rules: Vec<&str> = read.findings.iter().map(|f| f.rule).collect();
    assert_eq!(rules, ["missing_id", "unused_constant", "unused_key"]);
}

#[test]
fn a_loaded_tree_runs_as_written() {
    let source = Source {
        file: "t.json",
        text: GOOD,
        include: &|_| Err(String::new()),
    };
    let mut shared = Board::new();
    let loaded = descriptor::load(&source, &library(), &BTreeMap::new(), &mut shared);
    let mut tree = loaded.unwrap_or_else(|errors| panic!("{errors}"));
    let mut world = Vec::new();
    let mut tick = |tree: &mut Tree<Toy>, shared: &mut Board, ms| {
        tree.tick(Duration::from_millis(ms), shared, &mut world)
    };
    assert_eq!(tick(&mut tree, &mut shared, 0), Status::Running);
    let picked = Value::Text(Str::new("red").unwrap());
    assert_eq!(value(tree.local(), "thing"), Some(picked));
    let text = views::text(&tree.graph(), None);
    assert!(text.contains("move (MoveTo)  target=to speed="), "{text}");
    for ms in 1..6000 {
        if tick(&mut tree, &mut shared, ms) != Status::Running {
            break;
        }
    }
    assert_eq!(tree.status(), NodeStatus::Success);
    let done = shared.value(shared.index("done").unwrap());
    assert_eq!(done, Some(Value::Set(Set(0b1110))));
    assert_eq!(
        world.first().map(String::as_str),
        Some("move [0.1, 0.2, 0.9] 0.25")
    );
    assert_eq!(
        world.last().map(String::as_str),
        Some("move [0.0, 0.0, 1.0] 0.25")
    );
}
