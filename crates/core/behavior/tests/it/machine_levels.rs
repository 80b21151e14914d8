//! States inside states, regions, sub-behaviours, and the saved state.

#![allow(clippy::unwrap_used, clippy::match_bool, reason = "helpers of tests")]

use crate::machine_host;

use behavior::machine::{Definition, Final, Machine, RestoreError, RowDef, StateDef, names};
use behavior::status::ResetReason;
use behavior::{NodeStatus, Status};
use machine_host::{Host, fire, go, machine, states};

fn nested() -> Definition {
    let work = StateDef::new("work")
        .enter(&["enter"])
        .exit(&["exit"])
        .children(
            "a",
            vec![
                StateDef::new("a")
                    .enter(&["enter_child"])
                    .exit(&["exit_child"]),
                StateDef::new("b").enter(&["enter_child"]),
            ],
        );
    Definition::new("nested")
        .state(StateDef::new("idle"))
        .state(work)
        .row(RowDef::new("start", "idle", "work"))
        .row(RowDef::new("swap", "work.a", "work.b"))
        .row(RowDef::new("stop", "work", "idle"))
        .row(RowDef::new("again", "work", "="))
}

#[test]
fn t45_going_to_a_sibling_does_not_leave_the_parent() {
    let (mut machine, mut host) = (machine(&nested()), Host::default());
    assert_eq!(go(&mut machine, "start", &mut host).1, "work.a");
    assert_eq!(host.take_log(), "enter enter_child", "outermost first");
    assert_eq!(go(&mut machine, "swap", &mut host).1, "work.b");
    assert_eq!(host.take_log(), "exit_child enter_child");
    assert_eq!(go(&mut machine, "again", &mut host).1, "work.a");
    assert_eq!(host.take_log(), "exit enter enter_child");
    assert_eq!(go(&mut machine, "stop", &mut host).1, "idle");
    assert_eq!(host.take_log(), "exit_child exit", "innermost first");
}

#[test]
fn t47_the_row_of_a_child_goes_before_that_of_its_parent() {
    let both = nested()
        .row(RowDef::new("go", "work", "idle"))
        .row(RowDef::new("go", "work.a", "work.b").when(&["x"]));
    let mut first = machine(&both);
    go(&mut first, "start", &mut Host::default());
    assert_eq!(go(&mut first, "go", &mut Host::with(&["x"])).1, "work.b");
    assert_eq!(go(&mut first, "go", &mut Host::default()).1, "idle");
    let mut second = machine(&both);
    go(&mut second, "start", &mut Host::default());
    assert_eq!(
        go(&mut second, "go", &mut Host::default()).1,
        "idle",
        "blocked: the parent's"
    );
}

fn regions() -> Definition {
    let region = |name: &str| {
        StateDef::new(name).children(
            "a",
            vec![StateDef::new("a"), StateDef::new("b").end(Final::Success)],
        )
    };
    Definition::new("regions")
        .state(StateDef::new("idle"))
        .state(StateDef::new("P").regions(vec![region("1"), region("2")]))
        .initial("P")
        .row(RowDef::new("one", "P.1.a", "P.1.b"))
        .row(RowDef::new("both", "P.1.a", "P.1.b"))
        .row(RowDef::new("both", "P.2.a", "P.2.b"))
        .row(RowDef::new("out", "P.1.a", "idle"))
        .row(RowDef::new("out", "P.2.a", "P.2.b"))
        .row(RowDef::new("into", "idle", "P.2.b"))
}

#[test]
fn t49_each_region_takes_its_own_row() {
    let (mut machine, mut host) = (machine(&regions()), Host::default());
    assert_eq!(states(&machine), ["P.1.a", "P.2.a"]);
    assert!(go(&mut machine, "one", &mut host).0);
    assert_eq!(states(&machine), ["P.1.b", "P.2.a"]);
    assert_eq!(machine.status(), Status::Running);
    assert!(go(&mut machine, "both", &mut host).0);
    assert_eq!(states(&machine), ["P.1.b", "P.2.b"]);
    assert_eq!(machine.status(), Status::Success, "final in all regions");
}

#[test]
fn a_region_that_leaves_ends_all_and_entering_one_enters_all() {
    let (mut machine, mut host) = (machine(&regions()), Host::default());
    assert!(go(&mut machine, "out", &mut host).0);
    assert_eq!(states(&machine), ["idle"]);
    assert!(go(&mut machine, "into", &mut host).0);
    assert_eq!(states(&machine), ["P.1.a", "P.2.b"]);
    let graph = machine.describe();
    assert_eq!((graph.nodes.len(), graph.nodes[2].parent), (8, Some(1)));
    let statuses: Vec<NodeStatus> = machine.statuses().collect();
    assert_eq!(statuses[0], NodeStatus::Invalid);
    assert_eq!(statuses[7], NodeStatus::Success);
}

#[test]
fn becoming_final_is_told_once_all_of_it_is() {
    let mut told = regions();
    told.on_final = names(&["final"]);
    let (mut machine, mut host) = (machine(&told), Host::default());
    fire(&mut machine, "one", &mut host).unwrap();
    assert_eq!(host.take_log(), "");
    fire(&mut machine, "both", &mut host).unwrap();
    assert_eq!(host.take_log(), "final");
}

fn busy() -> Definition {
    Definition::new("busy")
        .state(StateDef::new("fetching").during("fetch", Some("fetched"), Some("lost")))
        .state(StateDef::new("carrying").during("carry", None, None))
        .state(StateDef::new("gone").end(Final::Failure))
        .row(RowDef::new("fetched", "fetching", "carrying"))
        .row(RowDef::new("lost", "*", "gone"))
        .row(RowDef::new("back", "carrying", "fetching"))
}

#[test]
fn a_state_runs_something_whose_result_fires_a_trigger() {
    let (mut machine, mut host) = (machine(&busy()), Host::default());
    host.results = vec![Status::Running, Status::Success, Status::Failure];
    machine.tick(&mut host).unwrap();
    assert_eq!(machine.state_name(), "fetching");
    machine.tick(&mut host).unwrap();
    assert_eq!(
        (machine.state_name(), host.take_log().as_str()),
        ("carrying", "run_fetch run_fetch")
    );
    machine.tick(&mut host).unwrap();
    machine.tick(&mut host).unwrap();
    assert_eq!(
        host.take_log(),
        "run_carry",
        "finished without a trigger: it rests"
    );
    fire(&mut machine, "lost", &mut host).unwrap();
    assert_eq!(host.take_log(), "", "what has finished is not halted");
    assert_eq!(machine.tick(&mut host), Ok(Status::Failure));
}

#[test]
fn leaving_halts_what_runs_and_waits_for_it_before_it_runs_again() {
    let (mut machine, mut host) = (machine(&busy()), Host::default());
    machine.tick(&mut host).unwrap();
    host.slow_to_halt = 3;
    fire(&mut machine, "fetched", &mut host).unwrap();
    assert_eq!(machine.statuses().next(), Some(NodeStatus::Halting));
    fire(&mut machine, "back", &mut host).unwrap();
    for _ in 0..3 {
        machine.tick(&mut host).unwrap();
    }
    assert_eq!(
        host.take_log(),
        "run_fetch halt_fetch halt_fetch halt_fetch run_fetch run_fetch"
    );
    assert!(machine.halt_all(ResetReason::Explicit, &mut host));
    assert_eq!(host.take_log(), "halt_fetch");
}

#[test]
fn a_saved_state_goes_on_after_the_file_was_edited() {
    let mut host = Host::default();
    let mut old = machine(&regions());
    fire(&mut old, "one", &mut host).unwrap();
    let mut bytes = Vec::new();
    old.save(&mut bytes);
    assert!(bytes.len() <= old.record_bytes());
    let mut same = machine(&regions());
    same.restore(&bytes).unwrap();
    assert_eq!(states(&same), ["P.1.b", "P.2.a"]);
    // One region lost the state, another region was added.
    let children = |inner: &[&str]| inner.iter().map(|name| StateDef::new(name)).collect();
    let edited =
        Definition::new("edited")
            .state(StateDef::new("new"))
            .state(StateDef::new("P").regions(vec![
                StateDef::new("0").children("n", children(&["n"])),
                StateDef::new("1").children("c", children(&["c"])),
                StateDef::new("2").children("z", children(&["z", "a"])),
            ]));
    let mut edited = machine(&edited);
    edited.restore(&bytes).unwrap();
    assert_eq!(states(&edited), ["P.0.n", "P.1.c", "P.2.a"]);
}

#[test]
fn a_record_that_does_not_fit_is_refused_and_changes_nothing() {
    let mut bytes = Vec::new();
    machine(&regions()).save(&mut bytes);
    let mut other: Machine = machine(&Definition::new("other").states(&["A"]));
    assert_eq!(other.restore(&bytes), Err(RestoreError::Unknown));
    for cut in 0..bytes.len() {
        assert!(other.restore(&bytes[..cut]).is_err());
    }
    bytes[0] = 9;
    assert_eq!(
        other.restore(&bytes),
        Err(RestoreError::Version { found: 9 })
    );
    assert_eq!(other.state_name(), "A");
}

#[test]
fn a_running_sub_behaviour_is_part_of_the_record() {
    let (mut first, mut host) = (machine(&busy()), Host::default());
    first.tick(&mut host).unwrap();
    let mut bytes = Vec::new();
    first.save(&mut bytes);
    let mut second = machine(&busy());
    second.restore(&bytes).unwrap();
    host.log.clear();
    fire(&mut second, "fetched", &mut host).unwrap();
    assert_eq!(host.take_log(), "halt_fetch");
}
