//! The event x state matrix, on the published matrices of filling and stacking.

#![allow(clippy::unwrap_used, clippy::match_bool, reason = "helpers of tests")]

use std::sync::Arc;

use behavior::Status;
use behavior::machine::{BehaviorId, Fault, RestoreError, StateId};
use behavior::matrix::{
    Cell, CellDef, Definition, EventSet, HandlerId, Handlers, Happening, Matrix, Next, StepError,
    Table, Vocabulary, check, unhandled,
};
use behavior::status::ResetReason;

const HANDLERS: &[&str] = &[
    "to_above_bin",
    "resume",
    "to_surface",
    "aim_again",
    "close_gripper",
    "lift",
    "ask_for_parts",
    "give_up",
    "rest",
    "choose_way",
    "over_holder",
    "over_column",
    "open_gripper",
    "count_or_regrip",
];

fn vocabulary() -> Vocabulary<'static> {
    Vocabulary {
        handlers: HANDLERS,
        behaviors: &["wait"],
        ..Vocabulary::default()
    }
}

fn fill_bin() -> Table {
    let text = include_str!("../../examples/fill_bin.toml");
    Definition::load("fill_bin.toml", text, &vocabulary()).unwrap()
}

fn stacking() -> Table {
    let text = include_str!("../../examples/bin_stacking.toml");
    Definition::load("bin_stacking.toml", text, &vocabulary()).unwrap()
}

/// Goes where its cell leads: to the chosen one of several states.
#[derive(Default)]
struct Host {
    stays: bool,
    choice: usize,
    anywhere: Option<StateId>,
    fails: bool,
    result: Option<Status>,
    log: Vec<String>,
}

impl Handlers for Host {
    fn handle(&mut self, handler: HandlerId, cell: Cell<'_>) -> Result<Next, Fault> {
        self.log.push(HANDLERS[usize::from(handler.0)].to_owned());
        if self.fails {
            return Err(Fault {
                reason: "on purpose",
            });
        }
        let to = self.anywhere.or(cell.goto.get(self.choice).copied());
        Ok(to.filter(|_| !self.stays).map_or(Next::Stay, Next::Goto))
    }

    fn run(&mut self, _: BehaviorId) -> Status {
        self.log.push("run".to_owned());
        self.result.unwrap_or(Status::Running)
    }

    fn halt(&mut self, _: BehaviorId, _: ResetReason) -> bool {
        self.log.push("halt".to_owned());
        true
    }
}

fn step(matrix: &mut Matrix, event: &str, host: &mut Host) -> String {
    let event = matrix.table().event(event).unwrap();
    matrix.step(event, host).unwrap();
    matrix.state_name().to_owned()
}

fn pick<'t>(table: &'t Table, pending: &[&str]) -> Option<&'t str> {
    let ids = pending.iter().map(|name| table.event(name).unwrap());
    let set = ids.fold(EventSet::EMPTY, EventSet::with);
    table.pick(set).map(|event| table.event_name(event))
}

#[test]
fn m01_a_cell_that_is_not_filled_in_does_nothing() {
    let mut matrix = Matrix::new(Arc::new(fill_bin()));
    let mut host = Host::default();
    for event in ["TIMEOUT", "WAYPOINT_REACHED", "STOP", "ATTACHED", "NONE"] {
        assert_eq!(step(&mut matrix, event, &mut host), "STANDBY");
    }
    assert!(host.log.is_empty());
    let nothing = matrix.trace().iter();
    assert!(
        nothing
            .clone()
            .all(|it| matches!(it, Happening::Handled { handler: None, .. }))
    );
    assert_eq!(nothing.count(), 5);
}

#[test]
fn m03_of_all_pending_events_the_first_in_precedence_is_handled() {
    let table = stacking();
    let order = [
        "BROKENGRIP",
        "GOAL_REACHED",
        "START",
        "ATTACHED",
        "DETACHED",
        "TIMEOUT",
        "NONE",
    ];
    for at in 0..order.len() {
        assert_eq!(pick(&table, &order[at..]), Some(order[at]));
    }
    assert_eq!(pick(&table, &[]), Some("NONE"), "the idle event");
    let without = Definition::new("m", &["B", "A"], &["S"])
        .compile(&vocabulary())
        .unwrap();
    assert_eq!(pick(&without, &["A", "B"]), Some("B"));
    assert_eq!(pick(&without, &[]), None);
}

#[test]
fn m09_a_grip_that_breaks_leads_to_standby_from_every_state() {
    for (table, event) in [(fill_bin(), "DETACHED"), (stacking(), "BROKENGRIP")] {
        let table = Arc::new(table);
        for node in &table.describe().nodes {
            let mut matrix = Matrix::new(table.clone());
            matrix.set_state(table.state(&node.id).unwrap());
            let mut host = Host::default();
            assert_eq!(step(&mut matrix, event, &mut host), "STANDBY");
            assert_eq!(host.log, ["give_up"]);
        }
    }
}

#[test]
fn m19_the_published_matrices_run_their_course_and_have_dead_events() {
    let mut matrix = Matrix::new(Arc::new(stacking()));
    let mut host = Host::default();
    for (event, choice, expected) in [
        ("START", 0, "PICKING"),
        ("NONE", 0, "PICKING"),
        ("GOAL_REACHED", 0, "ATTACH"),
        ("ATTACHED", 1, "FLIPPING"),
        ("GOAL_REACHED", 0, "DETACH"),
        ("DETACHED", 1, "PICKING"),
        ("GOAL_REACHED", 0, "ATTACH"),
        ("ATTACHED", 0, "PLACING"),
        ("GOAL_REACHED", 0, "DETACH"),
        ("DETACHED", 0, "STANDBY"),
    ] {
        host.choice = choice;
        assert_eq!(step(&mut matrix, event, &mut host), expected);
    }
    for table in [fill_bin(), stacking()] {
        let found = check(&table);
        let dead: Vec<&str> = found.iter().map(|it| it.place.as_str()).collect();
        assert_eq!(dead, ["STOP", "WAYPOINT_REACHED", "TIMEOUT"]);
        assert!(found.iter().all(|it| it.rule == "unhandled_event"));
    }
    let table = fill_bin();
    let start = table.event("START").unwrap();
    let deaf = unhandled(&table)
        .into_iter()
        .find(|(event, _)| *event == start)
        .unwrap();
    assert_eq!(deaf.1.len(), 3, "everywhere but in STANDBY");
}

#[test]
fn a_handler_may_stay_but_not_go_where_its_cell_does_not_lead() {
    let mut matrix = Matrix::new(Arc::new(fill_bin()));
    let mut host = Host {
        stays: true,
        ..Host::default()
    };
    assert_eq!(step(&mut matrix, "START", &mut host), "STANDBY");
    let start = matrix.table().event("START").unwrap();
    let holding = matrix.table().state("HOLDING").unwrap();
    host = Host {
        anywhere: Some(holding),
        ..Host::default()
    };
    let wrong = matrix.step(start, &mut host).unwrap_err();
    assert!(matches!(wrong, StepError::Undeclared { to, .. } if to == holding));
    host = Host {
        fails: true,
        ..Host::default()
    };
    assert!(matches!(
        matrix.step(start, &mut host),
        Err(StepError::Failed { .. })
    ));
    assert_eq!(matrix.state_name(), "STANDBY");
}

#[test]
fn names_without_a_meaning_are_refused_with_their_place() {
    let text = include_str!("../../examples/fill_bin.toml")
        .replace("\"lift\"", "\"lft\"")
        .replace("[cells.HOLDING]", "[cells.HOLDNG]")
        .replace("goto = \"ATTACH\"", "goto = \"ATACH\"")
        .replace("NONE = \"aim_again\"", "NOONE = \"aim_again\"");
    let wrong = Definition::load("f.toml", &text, &vocabulary())
        .unwrap_err()
        .to_string();
    let expected = [
        "f.toml:24:49: unknown state 'ATACH'; did you mean 'ATTACH'?",
        "f.toml:25:1: unknown event 'NOONE'; did you mean 'NONE'?",
        "f.toml:29:24: unknown handler 'lft'; did you mean 'lift'?",
        "f.toml:31:8: unknown state 'HOLDNG'; did you mean 'HOLDING'?",
    ];
    assert_eq!(wrong.lines().collect::<Vec<_>>(), expected);
    let known = Vocabulary {
        events: &["A", "B"],
        states: &["S", "T"],
        ..vocabulary()
    };
    let twice = Definition::new("m", &["A", "A"], &["S"])
        .cell(CellDef::new("S", "A", "rest"))
        .cell(CellDef::new("S", "A", "rest"));
    let wrong = twice.compile(&known).unwrap_err().to_string();
    for expected in [
        "'A' is defined twice",
        "filled in twice",
        "event 'B' is missing",
        "state 'T' is missing",
    ] {
        assert!(wrong.contains(expected), "{wrong}");
    }
    let empty = Definition::new("m", &[], &[])
        .compile(&vocabulary())
        .unwrap_err();
    assert_eq!(empty.list.len(), 2, "{empty}");
}

fn waiting() -> Definition {
    Definition::new("waiting", &["LEFT", "WAITED"], &["A", "B"])
        .cell(CellDef::new("A", "WAITED", "rest").goto(&["B"]))
        .cell(CellDef::new("A", "LEFT", "rest").goto(&["B"]))
        .cell(CellDef::new("B", "LEFT", "rest").goto(&["A"]))
        .during("A", "wait", Some("WAITED"), None)
}

#[test]
fn a_state_runs_something_whose_result_is_an_event() {
    let table = Arc::new(waiting().compile(&vocabulary()).unwrap());
    let mut matrix = Matrix::new(table.clone());
    let mut host = Host::default();
    assert_eq!(matrix.tick(EventSet::EMPTY, &mut host), Ok(None));
    host.result = Some(Status::Success);
    assert_eq!(
        matrix.tick(EventSet::EMPTY, &mut host),
        Ok(table.event("WAITED"))
    );
    assert_eq!(
        (matrix.state_name(), host.log.join(" ").as_str()),
        ("B", "run run rest")
    );
    let mut left = Matrix::new(table.clone());
    let mut host = Host::default();
    left.tick(EventSet::EMPTY, &mut host).unwrap();
    let mut bytes = Vec::new();
    left.save(&mut bytes);
    let mut again = Matrix::new(table);
    again.restore(&bytes).unwrap();
    step(&mut again, "LEFT", &mut host);
    assert_eq!(host.log.join(" "), "run rest halt");
}

#[test]
fn the_state_is_saved_by_name() {
    let mut matrix = Matrix::new(Arc::new(fill_bin()));
    step(&mut matrix, "START", &mut Host::default());
    let mut bytes = Vec::new();
    matrix.save(&mut bytes);
    let mut other = Matrix::new(Arc::new(stacking()));
    other.restore(&bytes).unwrap();
    assert_eq!(other.state_name(), "PICKING");
    matrix.set_state(matrix.table().state("HOLDING").unwrap());
    bytes.clear();
    matrix.save(&mut bytes);
    assert_eq!(other.restore(&bytes), Err(RestoreError::Unknown));
    assert_eq!(other.state_name(), "PICKING");
}
