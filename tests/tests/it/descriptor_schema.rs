//! The generated schema accepts what the loader accepts, and refuses what an
//! editor can know to be wrong.

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::too_many_lines,
    reason = "in tests"
)]

use crate::descriptor_common;

use behavior::descriptor::schema;
use descriptor_common::{GOOD, library, read};
use serde_json::Value;

fn validator() -> jsonschema::Validator {
    jsonschema::draft202012::new(&schema(&library())).unwrap()
}

#[test]
fn the_schema_is_one() {
    jsonschema::draft202012::meta::validate(&schema(&library())).unwrap();
}

#[test]
fn a_good_file_is_accepted_by_both() {
    assert!(read(GOOD).is_ok());
    let good: Value = serde_json::from_str(GOOD).unwrap();
    let wrong: Vec<String> = validator()
        .iter_errors(&good)
        .map(|e| e.to_string())
        .collect();
    assert_eq!(wrong, [""; 0]);
}

#[test]
fn a_loop_is_known_with_what_it_needs() {
    let text = r#"{"format": "behavior-tree/1", "name": "t", "root":
        {"id": "all", "type": "ForEach", "as": "x", "items": ["red", 2, [0.5, 1]], "children": [
            {"id": "rest", "name": "rest ${x}", "type": "Wait", "ports": {"seconds": 1}}]}}"#;
    let accepts = |text: &str| {
        let value: Value = serde_json::from_str(text).unwrap();
        validator().is_valid(&value)
    };
    assert!(accepts(text));
    for (from, to) in [
        ("\"as\": \"x\", ", ""),
        ("\"as\": \"x\"", "\"as\": \"a b\""),
        ("[\"red\", 2, [0.5, 1]]", "\"red\""),
        ("ForEach", "Sequence"),
    ] {
        assert!(!accepts(&text.replacen(from, to, 1)), "{to}");
    }
}

#[test]
fn mistakes_an_editor_can_know_are_refused_by_both() {
    let changes = [
        ("behavior-tree/1", "behavior-tree/9"),
        ("\"PickNext\"", "\"PickNxt\""),
        (
            "\"children\": [{\"id\": \"still\"",
            "\"childs\": [{\"id\": \"still\"",
        ),
        ("\"lower_priority\"", "\"lower\""),
        ("shared.stop:${arm}", "share.stop"),
        ("\"seconds\": 1}", "\"seconds\": -1}"),
        ("\"seconds\": 1}", "\"seconds\": \"one\"}"),
        ("\"seconds\": 1}", "\"second\": 1}"),
        ("{\"port\": \"to\"}", "{\"prt\": \"to\"}"),
        (
            "{\"type\": \"IsSeen\", \"ports\": {\"thing\": {\"bb\": \"local.thing\"}}}",
            "{\"type\": \"IsSeen\"}",
        ),
        (
            "{\"type\": \"IsSeen\", \"ports\": {\"thing\": {\"bb\": \"local.thing\"}}}",
            "{\"type\": \"IsSeen\", \"ports\": {\"thing\": \"rad\"}}",
        ),
        (
            "{\"type\": \"IsSeen\", \"ports\": {\"thing\": {\"bb\": \"local.thing\"}}}",
            "{\"type\": \"Wait\", \"ports\": {\"seconds\": 1}}",
        ),
        ("\"count\": \"${times}\"", "\"count\": 0"),
        (
            "\"count\": \"${times}\"",
            "\"count\": {\"bb\": \"local.tries\"}",
        ),
        ("\"id\": \"pick\"", "\"id\": \"a/b\""),
        ("\"default\": 0}", "\"default\": \"0\"}"),
        ("\"type\": \"bool\"", "\"type\": \"boolean\""),
        (
            "[{\"id\": \"still\", \"type\": \"Wait\", \"ports\": {\"seconds\": 1}}]",
            "[]",
        ),
        (
            "\"type\": \"PickNext\"",
            "\"type\": \"PickNext\", \"children\": [{\"id\": \"x\", \"type\": \"Wait\", \"ports\": {\"seconds\": 1}}]",
        ),
        (
            "\"type\": \"PickNext\"",
            "\"type\": \"PickNext\", \"guard\": {\"type\": \"IsSeen\"}",
        ),
        ("\"blackboard\"", "\"include\": [], \"blackboard\""),
        ("\"policy\": \"selected\"", "\"policy\": \"most\""),
        ("\"speed\": \"${slow}\"", "\"speed\": 3"),
    ];
    let validator = validator();
    for (from, to) in changes {
        assert!(GOOD.contains(from), "{from}");
        let text = GOOD.replacen(from, to, 1);
        let value: Value = serde_json::from_str(&text).unwrap();
        assert!(!validator.is_valid(&value), "the schema accepts {to}");
        assert!(read(&text).is_err(), "the loader accepts {to}");
    }
}

#[test]
fn older_names_are_accepted_but_not_offered() {
    let older = GOOD.replace("\"MoveTo\"", "\"Goto\"");
    assert!(validator().is_valid(&serde_json::from_str(&older).unwrap()));
    let schema = schema(&library());
    let offers = schema.pointer("/$defs/node/properties/type/anyOf");
    let offers = offers.and_then(Value::as_array).unwrap();
    let offer = |name: &str| offers.iter().find(|o| o.get("const") == Some(&name.into()));
    let description = offer("MoveTo").unwrap().get("description");
    assert_eq!(description, Some(&"Moves the hand (reach, travel)".into()));
    assert_eq!(offer("Goto").unwrap().get("deprecated"), Some(&true.into()));
    assert!(offer("Selector").is_some());
}

#[test]
fn ports_carry_their_docs_defaults_and_bounds() {
    let schema = schema(&library());
    let cases = schema
        .pointer("/$defs/node/allOf")
        .and_then(Value::as_array);
    let of_move = cases.unwrap().first().unwrap();
    let speed = of_move
        .pointer("/then/properties/ports/properties/speed")
        .unwrap();
    assert_eq!(speed.get("default"), Some(&0.5.into()));
    assert_eq!(
        speed.get("description"),
        Some(&"Speed, m/s (number)".into())
    );
    assert_eq!(speed.pointer("/anyOf/0/maximum"), Some(&2.0.into()));
}
