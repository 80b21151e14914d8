//! Modifiers of nodes: loops, times, checks, and the nodes that checks interrupt.

use crate::tree_support;

use behavior::board::{Board, In, Scope, Slot};
use behavior::status::Status;
use behavior::tree::{Abort, EventKind, Kind, Memory, Modifier, Node, Test};
use behavior::value::{Value, ValueType};
use tree_support::{Bench, Stand, act};

fn answers(node: Node<Bench>, ticks: u64) -> String {
    let mut stand = Stand::new(node, Board::new());
    (0..ticks).map(|now| stand.answer(now)).collect()
}

#[test]
fn repeat_runs_again_and_ends_after_its_count_or_a_failure() {
    let repeat = |count, break_on_failure| Modifier::Repeat {
        count,
        break_on_failure,
    };
    assert_eq!(answers(act("a", "S").with(repeat(3, true)), 4), "RRSR");
    assert_eq!(answers(act("a", "SF").with(repeat(3, true)), 2), "RF");
    assert_eq!(answers(act("a", "SFS").with(repeat(3, false)), 3), "RRS");
    assert_eq!(answers(act("a", "S").with(repeat(0, true)), 5), "RRRRR");
}

#[test]
fn retry_runs_again_so_often() {
    let retry = |max, reset_on_success| Modifier::Retry {
        max,
        reset_on_success,
    };
    assert_eq!(answers(act("a", "FFS").with(retry(2, true)), 3), "RRS");
    assert_eq!(answers(act("a", "F").with(retry(1, true)), 4), "RFRF");
    assert_eq!(answers(act("a", "F").with(retry(0, true)), 4), "RRRR");
    // Every run has its own retries, or all of them share what there is.
    assert_eq!(answers(act("a", "FSFS").with(retry(1, true)), 4), "RSRS");
    assert_eq!(answers(act("a", "FSFS").with(retry(1, false)), 4), "RSFS");
}

#[test]
fn answers_are_inverted_and_forced_when_the_node_is_finished() {
    assert_eq!(
        answers(act("a", "RSF").with(Modifier::InvertStatus), 3),
        "RFS"
    );
    let force = Modifier::ForceStatus(Status::Success);
    assert_eq!(answers(act("a", "RSF").with(force), 3), "RSS");
}

#[test]
fn a_delay_passes_before_each_start() {
    let delayed = act("a", "RS").with(Modifier::Delay(In::Literal(0.5)));
    let mut stand = Stand::new(delayed, Board::new());
    assert_eq!(stand.tick(0), ('R', String::new()));
    assert_eq!(stand.tick(499), ('R', String::new()));
    assert_eq!(stand.tick(500), ('R', "a starts, a R".to_owned()));
    assert_eq!(stand.tick(501), ('S', "a S".to_owned()));
    assert_eq!(stand.tick(502), ('R', String::new()));
}

#[test]
fn a_child_that_finishes_on_the_late_tick_wins_over_the_timeout() {
    let timeout = |script| act("a", script).with(Modifier::Timeout(In::Literal(1.0)));
    let mut stand = Stand::new(timeout("RS"), Board::new());
    assert_eq!((stand.answer(0), stand.answer(1500)), ('R', 'S'));
    let mut stand = Stand::new(timeout("R"), Board::new());
    assert_eq!((stand.answer(0), stand.answer(1000)), ('R', 'R'));
    assert_eq!(
        stand.tick(1001),
        ('F', "a R, a halts: timed out".to_owned())
    );
}

#[test]
fn a_wait_succeeds_when_its_time_has_passed() {
    let wait = Node::new("w", "Wait", Kind::Wait(In::Literal(0.25)), Vec::new());
    let mut stand = Stand::new(wait, Board::new());
    let answers = [0, 249, 250, 251, 500, 501].map(|now| stand.answer(now));
    assert_eq!(answers, ['R', 'R', 'S', 'R', 'R', 'S']);
}

#[test]
fn a_count_counts() {
    let count = Node::new("n", "Count", Kind::Count, vec![act("a", "RSF")]);
    let mut stand = Stand::new(count, Board::new());
    (0..3).for_each(|now| assert!(stand.answer(now) != '-'));
    let counts = stand.tree.counts(0).unwrap();
    assert_eq!((counts.ticks, counts.running), (3, 1));
    assert_eq!((counts.successes, counts.failures), (1, 1));
    assert_eq!(stand.tree.counts(1), None);
}

/// A board with the number `x`, which may not be there.
fn board(x: Option<f64>) -> (Board, Slot) {
    let mut local = Board::new();
    let default = x.map(Value::Number);
    let index = local.declare("x", ValueType::Number, default).unwrap();
    let scope = Scope::Local;
    (local, Slot { scope, index })
}

fn check(slot: Slot, test: Test, abort: Abort) -> Modifier {
    Modifier::CheckBlackboard { slot, test, abort }
}

#[test]
fn a_check_compares_the_value() {
    let half = Value::Number(0.5);
    let cases = [
        (Test::IsSet, Some(0.0), true),
        (Test::IsSet, None, false),
        (Test::IsUnset, None, true),
        (Test::Equals(half), Some(0.5), true),
        (Test::Equals(half), None, false),
        (Test::Differs(half), Some(0.25), true),
        (Test::Differs(half), None, true),
        (Test::Below(1.0), Some(0.5), true),
        (Test::Below(1.0), Some(1.0), false),
        (Test::Above(1.0), Some(1.5), true),
        (Test::Above(1.0), None, false),
    ];
    for (test, x, holds) in cases {
        let (local, slot) = board(x);
        let node = act("a", "S").with(check(slot, test, Abort::None));
        let expected = if holds { 'S' } else { 'F' };
        assert_eq!(
            Stand::new(node, local).answer(0),
            expected,
            "{test:?} of {x:?}"
        );
    }
}

fn set(stand: &mut Stand, slot: Slot, x: f64) {
    assert!(stand.tree.local_mut().set(slot.index, Value::Number(x)));
}

#[test]
fn a_check_that_aborts_its_own_node_is_asked_every_tick() {
    for (abort, letter) in [(Abort::None, 'R'), (Abort::Own, 'F'), (Abort::Both, 'F')] {
        let (local, slot) = board(Some(1.0));
        let node = act("a", "R").with(check(slot, Test::Above(0.0), abort));
        let mut stand = Stand::new(node, local);
        assert_eq!(stand.answer(0), 'R');
        set(&mut stand, slot, 0.0);
        let (answer, log) = stand.tick(1);
        assert_eq!(answer, letter, "{abort:?}");
        assert_eq!(log.contains("a halts: aborted"), letter == 'F');
    }
}

/// A selector with memory: `guarded` with its check, then `normal`.
fn guarded(script: &'static str, abort: Abort, memory: Memory) -> (Stand, Slot) {
    let (local, slot) = board(Some(0.0));
    let left = act("guarded", script).with(check(slot, Test::Above(0.0), abort));
    let root = Node::selector("root", memory, vec![left, act("normal", "R")]);
    (Stand::new(root, local), slot)
}

#[test]
fn a_check_that_holds_again_interrupts_siblings_to_the_right_under_memory() {
    for (abort, interrupts) in [
        (Abort::None, false),
        (Abort::Own, false),
        (Abort::LowerPriority, true),
        (Abort::Both, true),
    ] {
        let (mut stand, slot) = guarded("R", abort, Memory::Yes);
        assert_eq!(stand.tick(0).1, "normal starts, normal R");
        set(&mut stand, slot, 1.0);
        let log = stand.tick(1).1;
        if interrupts {
            let wanted = "normal halts: preempted, guarded starts, guarded R";
            assert_eq!(log, wanted, "{abort:?}");
            let holds = EventKind::Guard { holds: true };
            assert!(
                stand
                    .tree
                    .events()
                    .iter()
                    .any(|e| e.node == 1 && e.kind == holds)
            );
        } else {
            assert_eq!(log, "normal R", "{abort:?}");
        }
    }
}

#[test]
fn a_check_that_went_on_holding_interrupts_nothing() {
    let (mut stand, slot) = guarded("F", Abort::LowerPriority, Memory::Yes);
    set(&mut stand, slot, 1.0);
    assert_eq!(
        stand.tick(0).1,
        "guarded starts, guarded F, normal starts, normal R"
    );
    assert_eq!(stand.tick(1).1, "normal R");
    set(&mut stand, slot, 0.0);
    assert_eq!(stand.tick(2).1, "normal R");
    set(&mut stand, slot, 1.0);
    assert!(
        stand
            .tick(3)
            .1
            .starts_with("normal halts: preempted, guarded starts")
    );
}

#[test]
fn without_memory_the_left_child_is_asked_anyway() {
    let (mut stand, slot) = guarded("R", Abort::None, Memory::No);
    assert_eq!(stand.tick(0).1, "normal starts, normal R");
    set(&mut stand, slot, 1.0);
    let wanted = "guarded starts, guarded R, normal halts: preempted";
    assert_eq!(stand.tick(1).1, wanted);
}

#[test]
fn a_sequence_goes_back_to_the_child_whose_check_holds_again() {
    let (local, slot) = board(Some(1.0));
    let left = act("left", "S").with(check(slot, Test::Above(0.0), Abort::LowerPriority));
    let root = Node::sequence("root", Memory::Yes, vec![left, act("right", "R")]);
    let mut stand = Stand::new(root, local);
    assert_eq!(
        stand.tick(0).1,
        "left starts, left S, right starts, right R"
    );
    set(&mut stand, slot, 0.0);
    assert_eq!(stand.tick(1).1, "right R");
    set(&mut stand, slot, 1.0);
    let wanted = "right halts: preempted, left starts, left S, right starts, right R";
    assert_eq!(stand.tick(2).1, wanted);
}

#[test]
fn modifiers_nest_from_the_outside_in() {
    let (local, slot) = board(Some(0.0));
    let node = act("a", "R")
        .with(check(slot, Test::Above(0.0), Abort::None))
        .with(Modifier::InvertStatus);
    assert_eq!(node.modifiers.first(), Some(&Modifier::InvertStatus));
    let mut stand = Stand::new(node, local);
    assert_eq!(stand.answer(0), 'S');
    assert_eq!(stand.letters(), "S");
    assert_eq!(
        stand.tree.graph().nodes[0].detail,
        "InvertStatus, CheckBlackboard"
    );
}
