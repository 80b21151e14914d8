//! Nodes that take several ticks to stop, resets, faults and refusals.

use crate::tree_support;

use std::time::Duration;

use behavior::board::{Board, Fault, In, Scope, Slot};
use behavior::status::ResetReason;
use behavior::tree::{
    Abort, EventKind, Halt, Kind, MAX_DEPTH, MAX_NODES, Memory, Modifier, Node, ParallelPolicy,
    Test, Tree,
};
use behavior::value::{Value, ValueType};
use tree_support::{Bench, Stand, act, slow};

fn preempted() -> Stand {
    let children = vec![act("left", "FR"), slow("right", "R", 2)];
    Stand::new(Node::selector("root", Memory::No, children), Board::new())
}

#[test]
fn while_a_node_halts_nothing_else_runs() {
    let mut stand = preempted();
    assert_eq!(stand.answer(0), 'R');
    assert_eq!(stand.letters(), "RFR");
    let started = "left starts, left R, right halts: preempted";
    assert_eq!(stand.tick(1), ('R', started.to_owned()));
    assert_eq!(stand.letters(), "RRH");
    assert_eq!(stand.tick(2), ('R', "right halts: preempted".to_owned()));
    assert_eq!(stand.letters(), "RRH");
    assert_eq!(
        stand.tick(3),
        ('R', "right halts: preempted, left R".to_owned())
    );
    assert_eq!(stand.letters(), "RR-");
}

#[test]
fn a_halt_survives_a_kill() {
    let mut stand = preempted();
    let logs: Vec<String> = (0..5).map(|now| stand.tick(now).1).collect();
    let mut killed = preempted();
    for (now, log) in (0..).zip(logs) {
        assert_eq!(killed.tick(now).1, log);
        killed.kill(preempted);
    }
}

#[test]
fn an_answer_waits_until_what_it_stops_has_halted() {
    let timed = slow("a", "R", 1).with(Modifier::Timeout(In::Literal(0.5)));
    let root = Node::selector("root", Memory::Yes, vec![timed, act("b", "S")]);
    let mut stand = Stand::new(root, Board::new());
    assert_eq!(stand.answer(0), 'R');
    assert_eq!(stand.tick(501), ('R', "a R, a halts: timed out".to_owned()));
    assert_eq!(stand.letters(), "RH-");
    let wanted = "a halts: timed out, b starts, b S";
    assert_eq!(stand.tick(502), ('S', wanted.to_owned()));
}

#[test]
fn who_interrupts_starts_when_the_other_has_halted() {
    let make = || {
        let mut local = Board::new();
        let off = Some(Value::Bool(false));
        let index = local.declare("alarm", ValueType::Bool, off).unwrap();
        let check = Modifier::CheckBlackboard {
            slot: Slot {
                scope: Scope::Local,
                index,
            },
            test: Test::Equals(Value::Bool(true)),
            abort: Abort::LowerPriority,
        };
        let children = vec![act("recover", "R").with(check), slow("work", "R", 1)];
        Stand::new(Node::selector("root", Memory::Yes, children), local)
    };
    let mut stand = make();
    assert_eq!(stand.tick(0).1, "work starts, work R");
    assert!(stand.tree.local_mut().set(0, Value::Bool(true)));
    assert_eq!(stand.tick(1), ('R', "work halts: preempted".to_owned()));
    stand.kill(make);
    let wanted = "work halts: preempted, recover starts, recover R";
    assert_eq!(stand.tick(2).1, wanted);
}

fn reset(stand: &mut Stand) -> Halt {
    let now = Duration::from_secs(1);
    stand.log.clear();
    stand.tree.reset(
        ResetReason::Explicit,
        now,
        &mut stand.shared,
        &mut stand.log,
    )
}

#[test]
fn a_reset_stops_all_and_forgets_all() {
    let mut local = Board::new();
    local
        .declare("x", ValueType::Integer, Some(Value::Integer(1)))
        .unwrap();
    let shot = Node::new(
        "shot",
        "OneShot",
        Kind::OneShot(behavior::tree::OneShotPolicy::OnCompletion),
        vec![act("a", "SF")],
    );
    let root = Node::sequence("root", Memory::Yes, vec![shot, slow("b", "R", 1)]);
    let mut stand = Stand::new(root, local);
    let first = stand.tick(0);
    assert!(stand.tree.local_mut().set(0, Value::Integer(7)));
    assert_eq!(reset(&mut stand), Halt::NotYet);
    assert_eq!(stand.log, ["b halts: reset"]);
    assert_eq!(reset(&mut stand), Halt::Done);
    assert_eq!(stand.log, ["b halts: reset"]);
    assert_eq!(stand.letters(), "----");
    assert_eq!(stand.tree.local().value(0), Some(Value::Integer(1)));
    assert_eq!(reset(&mut stand), Halt::Done);
    assert_eq!(stand.tick(5), first);
}

#[test]
fn events_tell_what_changed_and_why() {
    let mut stand = preempted();
    stand.tick(0);
    stand.tick(1);
    let seen: Vec<(usize, String)> = stand
        .tree
        .events()
        .iter()
        .map(|event| match event.kind {
            EventKind::Status { from, to, reason } => {
                let why = reason.map_or("", ResetReason::name);
                (
                    event.node,
                    format!("{}{} {why}", from.letter(), to.letter()),
                )
            }
            other => (event.node, format!("{other:?}")),
        })
        .collect();
    let wanted = [(1, "FR "), (2, "RH preempted")];
    assert_eq!(seen, wanted.map(|(node, text)| (node, text.to_owned())));
    stand.tick(2);
    assert!(stand.tree.events().is_empty());
}

#[test]
fn a_fault_fails_the_node_and_is_told() {
    let mut stand = Stand::new(act("a", "x"), Board::new());
    assert_eq!(stand.answer(0), 'F');
    let fault = EventKind::Fault(Fault::Node("no such letter"));
    assert!(
        stand
            .tree
            .events()
            .iter()
            .any(|e| e.node == 0 && e.kind == fault)
    );

    let mut local = Board::new();
    let index = local.declare("seconds", ValueType::Number, None).unwrap();
    let slot = Slot {
        scope: Scope::Local,
        index,
    };
    let timed = act("a", "R").with(Modifier::Timeout(In::Key(slot)));
    let mut stand = Stand::new(timed, local);
    assert_eq!(stand.tick(0), ('F', String::new()));
    let fault = EventKind::Fault(Fault::Unset(slot));
    assert!(stand.tree.events().iter().any(|e| e.kind == fault));
    assert!(stand.tree.local_mut().set(index, Value::Number(1.0)));
    assert_eq!(stand.answer(1), 'R');
}

#[test]
fn the_tip_is_the_deepest_node_that_answered() {
    let inner = Node::sequence("inner", Memory::Yes, vec![act("b", "S"), act("c", "RF")]);
    let root = Node::selector("root", Memory::No, vec![act("a", "F"), inner]);
    let mut stand = Stand::new(root, Board::new());
    assert_eq!(stand.tree.tip(), None);
    stand.tick(0);
    assert_eq!(stand.tree.tip(), Some(4));
    stand.tick(1);
    assert_eq!(stand.tree.tip(), Some(4));
    reset(&mut stand);
    assert_eq!(stand.tree.tip(), None);
}

fn refused(root: Node<Bench>) -> String {
    match Tree::new("bad", root, Board::new()) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn everything_wrong_with_a_tree_is_named_at_once() {
    let policy = ParallelPolicy::Selected {
        children: vec![0, 3],
        synchronise: false,
    };
    let children = vec![
        act("twice", "S"),
        act("twice", "S"),
        Node::new("lonely", "Inverter", Kind::Inverter, Vec::new()),
        Node::new(
            "never",
            "Repeat",
            Kind::Repeat { count: Some(0) },
            vec![act("r", "S")],
        ),
        Node::new("nan", "Wait", Kind::Wait(In::Literal(f64::NAN)), Vec::new()),
        Node::new(
            "par",
            "Parallel",
            Kind::Parallel(policy),
            vec![act("p", "S")],
        ),
        act("late", "S").with(Modifier::Timeout(In::Literal(-1.0))),
    ];
    let text = refused(Node::sequence("root", Memory::Yes, children));
    for part in [
        "tree 'bad'",
        "'twice' is defined twice",
        "'lonely' (Inverter) has 0 children, 1 is needed",
        "'never' has the count 0",
        "'nan' has a time of NaN s",
        "'par' selects child 3 of 1",
        "'late' has a time of -1 s",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
    assert_eq!(text.lines().count(), 7);
}

#[test]
fn trees_that_are_too_deep_or_too_large_are_refused() {
    let deep = |levels: usize| {
        (1..levels).fold(act("leaf", "S"), |below, level| {
            Node::sequence(&format!("s{level}"), Memory::Yes, vec![below])
        })
    };
    assert_eq!(refused(deep(MAX_DEPTH)), "");
    assert!(refused(deep(MAX_DEPTH + 1)).contains("deeper than 64 levels"));
    let wide = |count: usize| {
        let child = |i| Node::sequence(&format!("c{i}"), Memory::Yes, Vec::new());
        Node::sequence("root", Memory::Yes, (1..count).map(child).collect())
    };
    assert_eq!(refused(wide(MAX_NODES)), "");
    let text = refused(wide(MAX_NODES + 5));
    assert!(text.contains("more than 16384 nodes"));
    assert_eq!(text.lines().count(), 2);
}
