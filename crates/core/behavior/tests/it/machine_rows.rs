//! What the reference library did in each situation, and where we differ on
//! purpose.

#![allow(clippy::unwrap_used, clippy::match_bool, reason = "helpers of tests")]

use crate::machine_host;

use behavior::Status;
use behavior::machine::{
    Definition, Happening, Machine, OrderedDef, QUEUE_CAPACITY, RowDef, StateDef, TriggerError,
    names,
};
use machine_host::{Host, VOCABULARY, fire, go, machine, states};

fn abc() -> Definition {
    Definition::new("abc").states(&["A", "B", "C"])
}

fn one(row: RowDef) -> Machine {
    machine(&abc().row(row))
}

fn is(taken: bool, state: &str) -> (bool, String) {
    (taken, state.to_owned())
}

#[test]
fn t01_a_row_leads_on_and_t03_a_trigger_without_one_can_be_ignored() {
    let mut host = Host::default();
    let mut plain = one(RowDef::new("go", "A", "B"));
    assert_eq!(go(&mut plain, "go", &mut host), is(true, "B"));
    let refused = fire(&mut plain, "go", &mut host).unwrap_err();
    assert!(matches!(refused, TriggerError::Invalid { .. }));
    let mut lenient = abc().row(RowDef::new("go", "A", "B"));
    lenient.ignore_invalid_triggers = true;
    let mut lenient = machine(&lenient);
    assert_eq!(go(&mut lenient, "go", &mut host), is(true, "B"));
    assert_eq!(go(&mut lenient, "go", &mut host), is(false, "B"));
}

#[test]
fn t05_t07_t09_guards_block_and_are_asked_from_left_to_right() {
    let mut host = Host::default();
    let mut guarded = one(RowDef::new("go", "A", "B").when(&["x"]));
    assert_eq!(go(&mut guarded, "go", &mut host), is(false, "A"));
    assert_eq!(host.take_log(), "c_x");
    let mut barred = one(RowDef::new("go", "A", "B").unless(&["x"]));
    assert_eq!(
        go(&mut barred, "go", &mut Host::with(&["x"])),
        is(false, "A")
    );
    let mut both = one(RowDef::new("go", "A", "B").when(&["x", "y"]));
    let mut host = Host::with(&["x"]);
    assert!(!go(&mut both, "go", &mut host).0);
    assert_eq!(host.take_log(), "c_x c_y");
    assert!(!go(&mut both, "go", &mut Host::with(&["y"])).0);
}

#[test]
fn t11_of_two_rows_with_opposite_guards_exactly_one_is_taken_even_if_the_guard_changes() {
    let pair = abc()
        .row(RowDef::new("go", "A", "B").when(&["x"]))
        .row(RowDef::new("go", "A", "C").unless(&["x"]));
    for (holding, expected) in [(&["x"][..], "B"), (&[], "C")] {
        let mut host = Host::with(holding);
        host.fickle = true;
        assert_eq!(go(&mut machine(&pair), "go", &mut host), is(true, expected));
        assert_eq!(host.take_log(), "c_x", "asked once");
    }
}

#[test]
fn t13_a_wildcard_is_the_fallback_and_t15_a_list_is_many_sources() {
    let fallback = abc()
        .row(RowDef::new("go", "A", "B").when(&["x"]))
        .row(RowDef::new("go", "*", "C"));
    assert_eq!(
        go(&mut machine(&fallback), "go", &mut Host::default()),
        is(true, "C")
    );
    let list = abc().initial("B").row(RowDef::new("go", "A B", "C"));
    assert_eq!(
        go(&mut machine(&list), "go", &mut Host::default()),
        is(true, "C")
    );
}

#[test]
fn t17_callbacks_run_in_the_order_of_the_reference() {
    let mut full = Definition::new("full")
        .state(StateDef::new("A").exit(&["exit"]))
        .state(StateDef::new("B").enter(&["enter"]))
        .row(
            RowDef::new("go", "A", "B")
                .when(&["x"])
                .prepare(&["prep"])
                .before(&["before"])
                .after(&["after"]),
        );
    full.prepare_event = names(&["prepare_event"]);
    full.before_state_change = names(&["before_change"]);
    full.after_state_change = names(&["after_change"]);
    full.finalize_event = names(&["finalize"]);
    let (mut machine, mut host) = (machine(&full), Host::default());
    assert!(!go(&mut machine, "go", &mut host).0);
    assert_eq!(host.take_log(), "prepare_event prep c_x finalize");
    host.holding.push("x");
    assert!(go(&mut machine, "go", &mut host).0);
    let order =
        "prepare_event prep c_x before_change before exit enter after after_change finalize";
    assert_eq!(host.take_log(), order);
    assert!(fire(&mut machine, "go", &mut host).is_err());
    assert_eq!(
        host.take_log(),
        "finalize",
        "refused triggers are finalized, too"
    );
}

#[test]
fn reflexive_rows_leave_and_enter_and_internal_rows_do_not() {
    let both = Definition::new("both")
        .state(StateDef::new("A").enter(&["enter"]).exit(&["exit"]))
        .row(RowDef::new("again", "*", "=").after(&["after"]))
        .row(RowDef::new("inside", "A", "").after(&["after"]));
    let (mut machine, mut host) = (machine(&both), Host::default());
    assert_eq!(go(&mut machine, "again", &mut host), is(true, "A"));
    assert_eq!(host.take_log(), "exit enter after");
    assert_eq!(go(&mut machine, "inside", &mut host), is(true, "A"));
    assert_eq!(host.take_log(), "after");
}

#[test]
fn t19_t21_automatic_triggers_exist_only_when_asked_for() {
    let plain = machine(&abc().row(RowDef::new("go", "A", "B")));
    let of_a: Vec<&str> = (plain.table().triggers_of(plain.state()))
        .map(|trigger| plain.table().trigger_name(trigger))
        .collect();
    assert_eq!(of_a, ["go"]);
    assert!(plain.table().trigger("to_B").is_none());
    let mut automatic = abc();
    automatic.auto_transitions = true;
    let mut automatic = machine(&automatic);
    assert_eq!(
        go(&mut automatic, "to_C", &mut Host::default()),
        is(true, "C")
    );
    assert_eq!(
        go(&mut automatic, "to_B", &mut Host::default()),
        is(true, "B")
    );
}

#[test]
fn t23_may_asks_guards_and_has_no_effect() {
    let machine = one(RowDef::new("go", "A", "B").when(&["x"]).prepare(&["prep"]));
    let id = machine.table().trigger("go").unwrap();
    let mut host = Host::default();
    assert!(!machine.may(id, &mut host));
    assert!(machine.may(id, &mut Host::with(&["x"])));
    assert_eq!(
        (machine.state_name(), host.take_log().as_str()),
        ("A", "c_x")
    );
    assert!(machine.trace().is_empty());
}

#[test]
fn t25_set_state_runs_nothing() {
    let inner = StateDef::new("work").children("a", vec![StateDef::new("a").enter(&["enter"])]);
    let mut machine = machine(&abc().state(inner));
    machine.set_state(machine.table().state("work").unwrap());
    assert_eq!(states(&machine), ["work.a"]);
}

#[test]
fn t27_t29_t30_names_without_a_meaning_are_refused_at_load() {
    let wrong = abc()
        .initial("Q")
        .row(RowDef::new("go", "A", "D").when(&["xx"]))
        .row(RowDef::new("go", "Z", "B").before(&["befor"]));
    let problems = wrong.compile(&VOCABULARY).unwrap_err().to_string();
    for expected in [
        "unknown state 'Q'",
        "unknown state 'D'",
        "unknown state 'Z'",
        "unknown guard 'xx'",
        "unknown callback 'befor'; did you mean 'before'?",
    ] {
        assert!(problems.contains(expected), "{problems}");
    }
}

#[test]
fn t31_a_trigger_fired_in_a_callback_waits_until_the_current_one_is_done() {
    let mut chain = abc()
        .row(
            RowDef::new("go", "A", "B")
                .before(&["posts"])
                .after(&["after"]),
        )
        .row(RowDef::new("on", "B", "C").before(&["before"]));
    chain.finalize_event = names(&["finalize"]);
    let (mut machine, mut host) = (machine(&chain), Host::default());
    host.posts = vec![machine.table().trigger("on").unwrap()];
    assert_eq!(go(&mut machine, "go", &mut host), is(true, "C"));
    assert_eq!(host.take_log(), "posts after finalize before finalize");
}

#[test]
fn t33_a_failure_drops_the_triggers_that_wait() {
    let chain = abc()
        .row(RowDef::new("go", "A", "B").after(&["posts", "fails"]))
        .row(RowDef::new("on", "B", "C"));
    let (mut machine, mut host) = (machine(&chain), Host::default());
    host.posts = vec![machine.table().trigger("on").unwrap()];
    let failed = fire(&mut machine, "go", &mut host).unwrap_err();
    assert!(failed.to_string().contains("on purpose"));
    assert_eq!(machine.state_name(), "B");
    assert_eq!(
        go(&mut machine, "on", &mut host),
        is(true, "C"),
        "nothing waits any more"
    );
}

#[test]
fn t35_a_failure_leaves_the_machine_in_the_source_until_it_is_left_and_then_in_the_destination() {
    let leaving = Definition::new("leaving")
        .state(StateDef::new("A").exit(&["exit", "fails"]))
        .state(StateDef::new("B"));
    let entering = Definition::new("entering")
        .state(StateDef::new("A"))
        .state(StateDef::new("B").enter(&["fails"]));
    for (definition, expected) in [(leaving, "A"), (entering, "B")] {
        let mut machine = machine(&definition.row(RowDef::new("go", "A", "B")));
        assert!(fire(&mut machine, "go", &mut Host::default()).is_err());
        assert_eq!(states(&machine), [expected]);
        let go = machine.table().trigger("go").unwrap();
        assert_eq!(machine.trace().last(), Some(&Happening::Failed(go)));
    }
}

#[test]
fn t37_ordered_triggers_go_round_from_the_initial_state() {
    let mut host = Host::default();
    let mut ring = machine(&abc().ordered("next", &[], true));
    let seen: Vec<String> = (0..4).map(|_| go(&mut ring, "next", &mut host).1).collect();
    assert_eq!(seen, ["B", "C", "A", "B"]);
    let mut open = machine(&abc().initial("B").ordered("next", &["A", "B", "C"], false));
    assert_eq!(go(&mut open, "next", &mut host), is(true, "C"));
    assert_eq!(go(&mut open, "next", &mut host), is(true, "A"));
    assert!(fire(&mut open, "next", &mut host).is_err());
    let mut guarded = abc();
    guarded.ordered.push(OrderedDef {
        conditions: names(&["x"]),
        ..abc().ordered("next", &[], true).ordered.remove(0)
    });
    assert!(!go(&mut machine(&guarded), "next", &mut host).0);
}

#[test]
fn t43_each_machine_of_a_table_answers_for_itself() {
    let table = abc()
        .row(RowDef::new("go", "A", "B"))
        .compile(&VOCABULARY)
        .unwrap();
    let table = std::sync::Arc::new(table);
    let (mut one, mut other) = (Machine::new(table.clone()), Machine::new(table));
    let mut host = Host::default();
    assert!(fire(&mut one, "go", &mut host).is_ok());
    assert!(fire(&mut one, "go", &mut host).is_err());
    assert!(fire(&mut other, "go", &mut host).is_ok());
}

#[test]
fn too_many_triggers_and_endless_ones_are_errors() {
    let ring = abc().row(RowDef::new("go", "A", "=").after(&["posts"]));
    let (mut machine, mut host) = (machine(&ring), Host::default());
    let id = machine.table().trigger("go").unwrap();
    host.posts = vec![id];
    assert_eq!(
        fire(&mut machine, "go", &mut host),
        Err(TriggerError::Endless)
    );
    host.posts = vec![id; QUEUE_CAPACITY + 1];
    let full = fire(&mut machine, "go", &mut host).unwrap_err();
    assert!(full.to_string().contains("more triggers posted"), "{full}");
}

#[test]
fn t51_from_the_final_state_of_the_palletizer_nothing_leads_on() {
    let guards = ["needs_flip", "placement_completes_stack"];
    let vocabulary = behavior::machine::Vocabulary {
        guards: &guards,
        ..Default::default()
    };
    let text = include_str!("../../examples/palletizing.toml");
    let table = Definition::load("palletizing.toml", text, &vocabulary).unwrap();
    assert_eq!(behavior::machine::check(&table), []);
    let mut machine = Machine::new(table.into());
    // Upside down, turned over, placed; the next one completes the layer. The
    // host answers by place, and its names do not matter here.
    let steps: [(&str, &[&'static str], &str); 8] = [
        ("go_pick", &[], "picking"),
        ("pick_done", &["x"], "flipping"),
        ("flip_done", &[], "picking"),
        ("pick_done", &[], "placing"),
        ("place_done", &[], "idle"),
        ("go_pick", &[], "picking"),
        ("pick_done", &[], "placing"),
        ("place_done", &["y"], "done"),
    ];
    for (trigger, holding, expected) in steps {
        assert_eq!(
            go(&mut machine, trigger, &mut Host::with(holding)),
            is(true, expected)
        );
    }
    assert_eq!(machine.status(), Status::Success);
    for trigger in ["go_pick", "pick_done", "flip_done", "place_done"] {
        assert!(fire(&mut machine, trigger, &mut Host::default()).is_err());
    }
}
