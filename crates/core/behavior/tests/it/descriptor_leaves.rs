//! Leaf types that a file declares, and the nodes that count and repeat as in BehaviorTree.CPP.

use std::collections::BTreeMap;
use std::time::Duration;

use behavior::board::{Board, Fault};
use behavior::descriptor::{self, Source};
use behavior::status::Status;
use behavior::tree::{Cx, DeclaredLeaf, Leaf, Library, Tree, any};
use behavior::{Str, Value};

use crate::descriptor_common::Toy;

/// Tells its ports, and answers with the letter of its type.
struct Told(DeclaredLeaf);

impl Leaf<Toy> for Told {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Toy>) -> Result<Status, Fault> {
        for port in &self.0.ports {
            let value = port.get(cx).map_or("none".to_owned(), |v| v.to_string());
            cx.world
                .push(format!("{} {}={value}", self.0.node, port.name));
            if port.name == "out" {
                port.set(cx, Value::Text(Str::new("said").unwrap()))?;
            }
        }
        Ok(Status::Success)
    }
}

fn source(text: &str) -> Source<'_> {
    Source {
        file: "t.json",
        text,
        include: &|_| Err(String::new()),
    }
}

fn file(leaves: &str, root: &str) -> String {
    format!(
        r#"{{"format": "behavior-tree/1", "name": "t", "blackboard": {{"local": {{"word": {{"type": "text"}}}}}},
        "leaves": {leaves}, "root": {root}}}"#
    )
}

fn load(text: &str, library: &Library<Toy>) -> Result<Tree<Toy>, String> {
    descriptor::load(&source(text), library, &BTreeMap::new(), &mut Board::new())
        .map_err(|errors| errors.to_string())
}

const LEAVES: &str = r#"{"Say": {"ports": {"text": {"type": "any"}, "loud": {"type": "bool", "default": true}}},
    "Think": {"ports": {"out": {"type": "text", "access": "write"}}}}"#;
const ROOT: &str = r#"{"id": "r", "type": "Sequence", "children": [
    {"id": "think", "type": "Think", "ports": {"out": {"bb": "local.word"}}},
    {"id": "say", "type": "Say", "ports": {"text": {"bb": "local.word"}}}]}"#;

#[test]
fn a_declared_leaf_gets_its_ports() {
    let library = Library::default().with_declared(|leaf| Ok(any(Told(leaf))));
    let mut tree = load(&file(LEAVES, ROOT), &library).unwrap();
    let mut log = Vec::new();
    let answer = tree.tick(Duration::ZERO, &mut Board::new(), &mut log);
    assert_eq!(answer, Status::Success);
    assert_eq!(log, ["think out=none", "say text='said'", "say loud=true"]);
}

#[test]
fn a_declared_leaf_that_nothing_provides_is_refused_when_it_shall_run() {
    let text = file(LEAVES, ROOT);
    let error = load(&text, &Library::default()).err().unwrap();
    assert!(error.contains("t.json:4:"), "{error}");
    assert!(error.contains("the leaf 'Think' is declared"), "{error}");
    // It can be looked at.
    let library = Library::<Toy>::default().with_placeholders();
    let findings = descriptor::check(&source(&text), &library, &BTreeMap::new(), &Board::new());
    assert_eq!(findings.unwrap(), []);
}

#[test]
fn mistakes_in_declarations_and_uses_have_their_places() {
    let library = Library::<Toy>::default().with_placeholders();
    let cases = [
        (r#"{"Wait": {}}"#, "node type of the engine"),
        (r#"{"Say": {"port": {}}}"#, "did you mean 'ports'?"),
        (
            r#"{"Say": {"ports": {"text": {"type": "txt"}}}}"#,
            "did you mean 'text'?",
        ),
        (
            r#"{"Say": {"ports": {"text": {"type": "text", "access": "all"}}}}"#,
            "unknown access 'all'",
        ),
        (
            r#"{"Say": {"ports": {"txt": {"type": "text"}}}}"#,
            "unknown port 'text'",
        ),
        (
            r#"{"Say": {"ports": {"text": {"type": "text", "access": "write"}}}}"#,
            "is written; bind it to a key",
        ),
        (
            r#"{"Say": {"ports": {"text": {"type": "number"}}}}"#,
            "a number is needed here",
        ),
        (r#"{"Says": {}}"#, "did you mean 'Says'?"),
    ];
    for (leaves, expected) in cases {
        let root = r#"{"id": "r", "type": "Say", "ports": {"text": "hello"}}"#;
        let error = load(&file(leaves, root), &library).err().unwrap();
        assert!(error.contains(expected), "{leaves}: {error}");
    }
}

#[test]
fn a_parallel_needs_the_counts_of_its_policy() {
    let library = Library::default();
    let ports = [
        r#"{"policy": "count", "successes": 1}"#,
        r#"{"policy": "finish"}"#,
        r#"{"successes": 1}"#,
    ];
    for ports in ports {
        let root =
            format!(r#"{{"id": "r", "type": "Parallel", "ports": {ports}, "children": []}}"#);
        let error = load(&file("{}", &root), &library).err().unwrap();
        assert!(
            error.contains("needs the ports 'successes' and 'failures'"),
            "{error}"
        );
    }
}
