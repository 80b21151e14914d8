//! Files of machines: all mistakes are reported at once, with their places; checks find
//! probable mistakes.

#![allow(clippy::unwrap_used, clippy::match_bool, reason = "helpers of tests")]

use crate::machine_host;

use behavior::machine::{Definition, RowDef, StateDef, check, check_events, unhandled};
use machine_host::{VOCABULARY, machine};
use proptest::prelude::*;

fn problems(file: &str, text: &str) -> Vec<String> {
    let wrong = Definition::load(file, text, &VOCABULARY).unwrap_err();
    wrong.to_string().lines().map(str::to_owned).collect()
}

#[test]
fn every_mistake_of_a_toml_file_is_named_with_its_place() {
    let text = r#"version = 1
name = "door"
initial = "closd"
states = ["closed", "open", "open", { name = "ajar", entr = "enter", during = "fetsch" }]

[[rows]]
trigger = "push"
source = ["closed", "opn"]
dest = "open"
conditions = ["x", "z"]

[[rows]]
source = "*"
dest = 3
before = "bfore"
"#;
    let expected = [
        "door.toml:3:11: unknown state 'closd'; did you mean 'closed'?",
        "door.toml:4:29: state 'open' is defined twice (first in line 4); rename one of them",
        "door.toml:4:54: a state has no key 'entr'; did you mean 'enter'?",
        "door.toml:4:79: unknown sub-behaviour 'fetsch'; did you mean 'fetch'?",
        "door.toml:8:21: unknown state 'opn'; did you mean 'open'?",
        "door.toml:10:20: unknown guard 'z'; known are: x, y",
        "door.toml:12:1: a row has no 'trigger'; add trigger = \"...\"",
        "door.toml:14:8: 'dest' of a row must be a text, not the integer 3",
    ];
    assert_eq!(problems("door.toml", text), expected);
}

#[test]
fn json_files_are_read_alike_and_null_is_an_internal_row() {
    let text = r#"{"version": 1, "name": "j", "initial": "A", "states": ["A", "B"],
 "rows": [{"trigger": "t", "source": "A", "dest": null, "after": "after"},
          {"trigger": "t", "source": "B", "dest": "C"}]}"#;
    let expected = "j.json:3:51: unknown state 'C'; known are: A, B";
    assert_eq!(problems("j.json", text), [expected]);
    let read = Definition::load("j.json", &text.replace("\"C\"", "\"=\""), &VOCABULARY).unwrap();
    let edges = read.describe().edges;
    assert_eq!((edges[0].label.as_str(), edges[0].to), ("t (internal)", 0));
    let doubled = text.replace("\"name\": \"j\"", "\"name\": \"j\", \"name\": \"k\"");
    assert!(problems("j.json", &doubled)[0].contains("given twice"));
}

#[test]
fn broken_files_say_where() {
    for (file, text) in [
        ("f.toml", "version = 1\nstates = [\"a\"\nname = 2"),
        ("f.toml", "version = 1\nversion = 1"),
        ("f.toml", "x = nan"),
        ("f.toml", "x = 99999999999999999999"),
        ("f.toml", ""),
        ("f.json", "[]"),
        ("f.json", "{"),
        (
            "f.toml",
            "version = 2\nname=\"a\"\nstates=[\"a\"]\ninitial=\"a\"",
        ),
    ] {
        let found = problems(file, text);
        assert!(found[0].starts_with(&format!("{file}:")), "{found:?}");
    }
}

#[test]
fn triggers_are_checked_against_what_the_host_and_the_file_know() {
    let machine = Definition::new("m")
        .state(StateDef::new("A").during("fetch", Some("dne"), None))
        .row(RowDef::new("done", "A", "="));
    let wrong = machine.compile(&VOCABULARY).unwrap_err().to_string();
    assert_eq!(wrong, "m: unknown trigger 'dne'; did you mean 'done'?");
    let mut vocabulary = VOCABULARY;
    vocabulary.triggers = &["start", "donee"];
    let wrong = machine.compile(&vocabulary).unwrap_err().to_string();
    assert!(
        wrong.contains("unknown trigger 'done'; did you mean 'donee'?"),
        "{wrong}"
    );
    let known = Definition::new("m")
        .states(&["A"])
        .row(RowDef::new("donee", "A", "="));
    let table = known.compile(&vocabulary).unwrap();
    assert_eq!(
        table.trigger("donee").unwrap().0,
        1,
        "ids are places in the host's list"
    );
}

#[test]
fn hostile_definitions_are_refused_with_reason() {
    let mut deep = StateDef::new("s");
    for _ in 0..40 {
        deep = StateDef::new("s").children("s", vec![deep]);
    }
    let wrong = Definition::new("deep")
        .state(deep)
        .compile(&VOCABULARY)
        .unwrap_err();
    assert!(wrong.to_string().contains("deep in one another"));
    let many: Vec<String> = (0..300).map(|n| format!("s{n}")).collect();
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    let wrong = Definition::new("many")
        .states(&many)
        .compile(&VOCABULARY)
        .unwrap_err();
    assert!(wrong.to_string().contains("at most 256"));
    let none = Definition::new("none").compile(&VOCABULARY).unwrap_err();
    assert!(none.to_string().contains("no states"));
    let mut wide = Definition::new("wide").states(&many[..256]);
    for _ in 0..300 {
        wide = wide.row(RowDef::new("t", "*", "s0"));
    }
    let wrong = wide.compile(&VOCABULARY).unwrap_err();
    assert!(wrong.to_string().contains("more than 65000 rows"));
    let odd = StateDef::new("a.b").children("x", vec![StateDef::new("y")]);
    let empty = StateDef {
        parallel: true,
        ..StateDef::new("p")
    };
    let wrong = Definition::new("odd")
        .state(odd)
        .state(empty)
        .compile(&VOCABULARY)
        .unwrap_err();
    assert_eq!(wrong.list.len(), 3, "{wrong}");
}

/// Without an index of lines and with limits checked last, each of these took minutes.
#[test]
fn a_file_beyond_a_limit_is_refused_for_that_before_anything_else_is_looked_at() {
    let mut states = "version = 1\nname = \"m\"\ninitial = \"nowhere\"\n".to_owned();
    let mut rows = format!("{states}states = [\"a\"]\n");
    for number in 0..65_001 {
        let state = format!("[[states]]\nname = \"s{number}\"\nenter = \"x{number}\"\n");
        states.push_str(&state);
        rows.push_str("[[rows]]\ntrigger = \"t\"\nsource = \"b\"\ndest = \"c\"\n");
    }
    assert_eq!(
        problems("m.toml", &states),
        ["m.toml:773:8: 65001 states; at most 256 can be"]
    );
    assert_eq!(
        problems("m.toml", &rows),
        ["m.toml:260005:1: 65001 rows; at most 65000 can be"]
    );
}

#[test]
fn tables_of_a_file_are_counted_before_they_are_read() {
    let mut text = "version = 1\nname = \"m\"\nstates = [\"a\"]\n[conditions]\n".to_owned();
    for number in 0..300 {
        let condition = format!("c{number} = {{ do = \"x\" }}\n");
        text.push_str(&condition);
    }
    assert_eq!(
        problems("m.toml", &text),
        ["m.toml:261:1: 300 conditions; at most 256 can be"]
    );
}

#[test]
fn a_file_that_is_too_deep_is_not_said_to_be_of_another_kind() {
    let deep = format!("{}{}", "[".repeat(1000), "]".repeat(1000));
    let of_toml = problems("m.toml", &format!("x = {deep}"));
    assert_eq!(
        of_toml,
        ["m.toml:1:85: tables and lists are nested deeper than 80 levels; use fewer"]
    );
    let of_json = &problems("m.json", &deep)[0];
    assert!(
        of_json.contains("nested deeper than 128 levels"),
        "{of_json}"
    );
}

#[test]
fn many_rows_of_one_cell_are_checked_in_bounded_time() {
    let mut machine = Definition::new("wide").states(&["A", "B"]);
    for _ in 0..60_000 {
        machine = machine.row(RowDef::new("t", "A", "B").when(&["x"]));
    }
    let table = machine.compile(&VOCABULARY).unwrap();
    let same = |it: &behavior::Finding| it.rule == "same_guards";
    assert_eq!(check(&table).into_iter().filter(same).count(), 59_999);
}

#[test]
fn checks_name_what_is_probably_not_meant() {
    let odd = Definition::new("odd")
        .states(&["A", "B", "C", "lost"])
        .state(StateDef::new("end").end(behavior::machine::Final::Success))
        .row(RowDef::new("go", "A", "B").when(&["x"]))
        .row(RowDef::new("go", "A", "C").when(&["x"]))
        .row(RowDef::new("go", "A", "end"))
        .row(RowDef::new("go", "A", "B").when(&["y"]))
        .row(RowDef::new("there", "B", "C"))
        .row(RowDef::new("back", "C", "B"))
        .row(RowDef::new("never", "lost", "A"));
    let found = check(machine(&odd).table());
    let found: Vec<(&str, &str)> = found
        .iter()
        .map(|it| (it.rule, it.place.as_str()))
        .collect();
    let expected = [
        ("unreachable_state", "lost"),
        ("never_final", "B"),
        ("never_final", "C"),
        ("same_guards", "row 2"),
        ("shadowed_row", "row 4"),
        ("unhandled_trigger", "never"),
    ];
    assert_eq!(found, expected);
    let stuck = Definition::new("stuck")
        .states(&["A", "B"])
        .row(RowDef::new("go", "A", "B"));
    let table = machine(&stuck).table().clone();
    assert_eq!(check(&table)[0].rule, "dead_end");
    assert_eq!(unhandled(&table)[0].1, [table.state("B").unwrap()]);
}

#[test]
fn events_that_lead_to_the_same_state_or_in_a_circle_are_found() {
    let odd = Definition::new("odd")
        .states(&["A", "B", "ign"])
        .state(StateDef::new("end").end(behavior::machine::Final::Success))
        .row(RowDef::new("nothing", "*", "ign"))
        .row(RowDef::new("dropped", "A", "B"))
        .row(RowDef::new("dropped", "B", "A"))
        .row(RowDef::new("seen", "A", "B"))
        .row(RowDef::new("seen", "B", "A").when(&["x"]))
        .row(RowDef::new("ok", "A", "="))
        .row(RowDef::new("ok", "ign", "end"));
    let table = machine(&odd).table().clone();
    let found = check_events(&table, &["nothing", "dropped", "seen"]);
    let found: Vec<(&str, &str)> = found
        .iter()
        .map(|it| (it.rule, it.place.as_str()))
        .collect();
    assert_eq!(
        found,
        [("event_of_own_state", "row 1"), ("event_circle", "A")]
    );
    let message = &check_events(&table, &["ok", "dropped"])[0].message;
    assert!(message.contains("'ok' leads from 'A'"), "{message}");
    // Code may fire a trigger that leads to the same state: it is not a condition.
    let rules = check(&table);
    assert!(
        rules.iter().all(|it| !it.rule.starts_with("event")),
        "{rules:?}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_text_crashes_the_reader(text in "\\PC{0,80}", at in 0_usize..600, cut in 0_usize..9) {
        let good = include_str!("../../examples/palletizing.toml");
        let mut bytes: Vec<char> = good.chars().collect();
        let at = at.min(bytes.len());
        bytes.splice(at..(at + cut).min(bytes.len()), text.chars());
        let broken: String = bytes.into_iter().collect();
        for (file, text) in [("f.toml", &broken), ("f.json", &text), ("f.toml", &text)] {
            if let Err(wrong) = Definition::load(file, text, &VOCABULARY) {
                prop_assert!(wrong.list.iter().all(|it| it.place.line > 0), "{}", wrong);
            }
        }
    }
}
