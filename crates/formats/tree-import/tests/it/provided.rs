//! Leaves that subtrees of a tree file provide.

use std::collections::BTreeMap;

use behavior::board::Board;
use behavior::descriptor::{self, Source};
use tree_import::{Errors, Imported};

use crate::support::{library, whole};

const LEAVES: &str = r#"{"format": "behavior-tree/1", "subtrees": {
"Grasp": {
  "ports": {"object": {"type": "text"}, "times": {"type": "integer", "default": 1},
            "offset": {"type": "numbers", "default": [0, 0]}},
  "root": {"id": "pick", "type": "Pick", "ports": {"object": {"port": "object"}}}},
"Seen": {"root": {"id": "look", "type": "Look"}},
"Level": {"ports": {"value": {"type": "number"}}, 
  "root": {"id": "level", "type": "CheckBlackboard", "ports": {"key": {"port": "value"}, "above": 1}}}
}, "leaves": {"Look": {}, "Pick": {"ports": {"object": {"type": "text"}}}}}"#;

fn leaves(text: &str) -> Source<'_> {
    Source {
        file: "some/where/own.tree.json",
        text,
        include: &|_| Err("there is none".to_owned()),
    }
}

fn import(xml: &str, provided: &str) -> Result<Imported, Errors> {
    let source = leaves(provided);
    tree_import::import("t.xml", &whole(xml), &|_| None, None, Some(&source))
}

#[track_caller]
fn assert_refused(xml: &str, provided: &str, expected: &[&str]) {
    let text = import(xml, provided).unwrap_err().to_string();
    for part in expected {
        assert!(text.contains(part), "'{part}' is missing in:\n{text}");
    }
}

/// What `bt check` finds in the printed file beside the one that provides the leaves.
fn checked(json: &str) -> Vec<String> {
    let source = Source {
        file: "t.tree.json",
        text: json,
        include: &|name| match name {
            "own.tree.json" => Ok(LEAVES.to_owned()),
            other => Err(format!("unknown '{other}'")),
        },
    };
    let library = library(&BTreeMap::new());
    let found = descriptor::check(&source, &library, &BTreeMap::new(), &Board::new());
    let found = found.unwrap_or_else(|errors| panic!("{errors}\n{json}"));
    found.iter().map(ToString::to_string).collect()
}

#[test]
fn a_leaf_with_the_name_of_a_subtree_is_a_use_of_it() {
    let xml = r#"<Sequence><Seen/><Grasp name="get" object="red" times="2" offset="1;2.5"/>
        <Script code="level := 3"/><Level value="{level}"/><Talk text="hello"/></Sequence>"#;
    let imported = import(xml, LEAVES).unwrap();
    let names: Vec<&str> = imported.leaves.iter().map(|l| l.name.as_str()).collect();
    assert_eq!(names, ["Talk"], "the others are provided");
    for part in [
        r#""includes": ["own.tree.json"]"#,
        r#"{"id": "Seen", "type": "Subtree", "subtree": "Seen"}"#,
        r#""subtree": "Grasp""#,
        r#""object": "red", "times": 2, "offset": [1,2.5]"#,
    ] {
        assert!(imported.json.contains(part), "{part}: {}", imported.json);
    }
    assert_eq!(checked(&imported.json), [""; 0]);
}

#[test]
fn a_key_has_the_type_of_the_port_that_it_is_bound_to() {
    let xml = r#"<root BTCPP_format="4" main_tree_to_execute="Main">
        <BehaviorTree ID="Main"><SubTree ID="Bring" what="7"/></BehaviorTree>
        <BehaviorTree ID="Bring"><Sequence><Grasp object="{what}"/><Seen/><Script code="n := 2"/>
        <Level value="{n}"/>
        </Sequence></BehaviorTree></root>"#;
    let imported = import(xml, LEAVES).unwrap();
    assert!(
        imported.json.contains(r#""default": "7""#),
        "a text, though it looks like a number: {}",
        imported.json
    );
    assert_eq!(checked(&imported.json), [""; 0]);
}

#[test]
fn a_default_of_the_model_is_given_to_the_subtree() {
    let xml = r#"<root BTCPP_format="4"><BehaviorTree ID="Main"><Sequence><Grasp/></Sequence>
        </BehaviorTree><TreeNodesModel><Action ID="Grasp">
        <input_port name="object" type="std::string" default="red"/>
        <input_port name="times" type="int" default=""/></Action></TreeNodesModel></root>"#;
    let imported = import(xml, LEAVES).unwrap();
    let ports = r#""ports": {"object": "red"}"#;
    assert!(imported.json.contains(ports), "{}", imported.json);
}

#[test]
fn what_does_not_fit_is_refused_with_both_places() {
    let xml = "<Sequence>\n<Grasp objct=\"red\"/>\n<Grasp object=\"a\" times=\"1.5\"/>\n\
               <Grasp object=\"a\" offset=\"1;b\"/>\n<Script code=\"n := 1\"/>\n\
               <Grasp object=\"{n}\"/>\n<Grasp object=\"b\" times=\"{n}\"/></Sequence>";
    let own = "the subtree 'Grasp' (some/where/own.tree.json:2)";
    let line = |line: u32, words: &str| format!("t.xml:{line}:1: Grasp: {words}");
    let expected = [
        line(
            2,
            &format!("{own} has no port 'objct'; did you mean 'object'?"),
        ),
        line(2, &format!("{own} needs the port 'object'")),
        line(
            3,
            &format!("port 'times' of {own} is of type integer, here it is '1.5'"),
        ),
        line(
            4,
            &format!("port 'offset' of {own} is of type numbers, here it is '1;b'"),
        ),
        line(
            6,
            &format!(
                "port 'object' of {own} is of type text, here it is the key 'n' of type number"
            ),
        ),
        line(
            7,
            &format!(
                "port 'times' of {own} is of type integer, here it is the key 'n' of type number"
            ),
        ),
    ];
    assert_refused(xml, LEAVES, &expected.each_ref().map(String::as_str));
}

#[test]
fn an_output_is_bound_to_a_key() {
    let xml = "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">\n<Level value=\"3\"/>\n\
        </BehaviorTree><TreeNodesModel><Action ID=\"Level\"><output_port name=\"value\"/>\
        </Action></TreeNodesModel></root>";
    let words = "t.xml:2:1: Level: port 'value' of the subtree 'Level' (some/where/own.tree.json:7) \
                 is an output; bind it to a key, {KEY}";
    assert_refused(xml, LEAVES, &[words]);
    let keyed = xml.replace("\"3\"", "\"{level}\"");
    checked(&import(&keyed, LEAVES).unwrap().json);
}

#[test]
fn a_file_that_cannot_provide_leaves_is_refused() {
    let root = LEAVES.replace(
        "\"leaves\"",
        "\"root\": {\"id\": \"x\", \"type\": \"Look\"}, \"leaves\"",
    );
    assert_refused(
        "<A/>",
        &root,
        &[
            "own.tree.json:9",
            "a file that provides leaves must not have a root",
        ],
    );
    assert_refused("<A/>", "{", &["own.tree.json:1"]);
    assert_refused(
        "<A/>",
        r#"{"format": "behavior-tree/1"}"#,
        &["own.tree.json:1", "it has no subtrees"],
    );
}

#[test]
fn a_tree_with_the_name_of_a_provided_leaf_is_refused() {
    let xml = "<root BTCPP_format=\"4\" main_tree_to_execute=\"Main\">\n\
        <BehaviorTree ID=\"Main\"><SubTree ID=\"Grasp\"/></BehaviorTree>\n\
        <BehaviorTree ID=\"Grasp\"><A/></BehaviorTree></root>";
    let expected = [
        "t.xml:3:",
        "tree 'Grasp' has the name of the subtree 'Grasp' (some/where/own.tree.json:2)",
    ];
    assert_refused(xml, LEAVES, &expected);
}
