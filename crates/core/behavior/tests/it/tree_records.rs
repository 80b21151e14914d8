//! A tree that is dropped at any tick and restored from its checkpoint continues as
//! if nothing had happened; no bytes make it fall over.

use crate::tree_support;

use behavior::board::{Board, In, Scope, Slot};
use behavior::status::Status;
use behavior::tree::{Abort, Kind, Memory, Modifier, Node, OneShotPolicy, ParallelPolicy, Test};
use behavior::value::{Value, ValueType};
use proptest::prelude::*;
use tree_support::{Act, Bench, Stand, act};

const SCRIPTS: [&str; 8] = ["S", "F", "R", "RS", "RRF", "FS", "SRF", "RFRS"];
const NAMES: [&str; 4] = ["a", "b", "c", "d"];

/// What a tree is made from, so that it can be made twice.
#[derive(Clone, Debug)]
struct Plan {
    kind: u8,
    script: usize,
    halts: u32,
    modifier: u8,
    children: Vec<Plan>,
}

fn plans() -> impl Strategy<Value = Plan> {
    let leaf = (0..SCRIPTS.len(), 0..3_u32, 0..20_u8).prop_map(|(script, halts, modifier)| Plan {
        kind: 0,
        script,
        halts,
        modifier,
        children: Vec::new(),
    });
    leaf.prop_recursive(4, 40, 4, |inner| {
        let children = prop::collection::vec(inner, 1..4);
        (1..18_u8, 0..20_u8, children).prop_map(|(kind, modifier, children)| Plan {
            kind,
            script: 0,
            halts: 0,
            modifier,
            children,
        })
    })
}

fn kind(plan: &Plan) -> Kind<Bench> {
    match plan.kind {
        1 | 2 => Kind::Sequence(Memory::Yes),
        3 => Kind::Sequence(Memory::No),
        4 | 5 => Kind::Selector(Memory::Yes),
        6 => Kind::Selector(Memory::No),
        7 => Kind::Parallel(ParallelPolicy::All { synchronise: true }),
        8 => Kind::Parallel(ParallelPolicy::One),
        9 => Kind::Inverter,
        10 => Kind::Repeat { count: Some(2) },
        11 => Kind::Retry { count: Some(2) },
        12 => Kind::OneShot(OneShotPolicy::OnSuccess),
        13 => Kind::Count,
        14 => Kind::Timeout(In::Literal(0.002)),
        15 => Kind::Condition(Status::Failure),
        _ => Kind::Converter {
            from: Status::Running,
            to: Status::Failure,
        },
    }
}

fn modifier(number: u8) -> Option<Modifier> {
    let slot = Slot {
        scope: Scope::Local,
        index: 0,
    };
    let check = |abort| Modifier::CheckBlackboard {
        slot,
        test: Test::Equals(Value::Bool(true)),
        abort,
    };
    Some(match number {
        0 => Modifier::Delay(In::Literal(0.002)),
        1 => Modifier::Timeout(In::Literal(0.003)),
        2 => check(Abort::Own),
        3 | 4 => check(Abort::LowerPriority),
        5 => check(Abort::Both),
        6 => Modifier::Retry {
            max: 1,
            reset_on_success: false,
        },
        7 => Modifier::ForceStatus(Status::Failure),
        _ => return None,
    })
}

fn node(plan: &Plan, id: &str) -> Node<Bench> {
    let mut node = if plan.kind == 0 {
        let leaf = Act {
            name: NAMES[id.len() % NAMES.len()],
            script: SCRIPTS[plan.script],
            halts: plan.halts,
        };
        Node::leaf(id, "Act", leaf)
    } else {
        let one = plan.kind > 8;
        let kept = if one { 1 } else { plan.children.len() };
        let children = plan.children.iter().take(kept).enumerate();
        let children = children.map(|(i, child)| node(child, &format!("{id}.{i}")));
        Node::new(id, "node", kind(plan), children.collect())
    };
    node.modifiers.extend(modifier(plan.modifier));
    node
}

fn stand(plan: &Plan) -> Stand {
    let mut local = Board::new();
    local
        .declare("on", ValueType::Bool, Some(Value::Bool(false)))
        .unwrap();
    Stand::new(node(plan, "n"), local)
}

/// The answer, what was done, and the statuses.
fn tick(stand: &mut Stand, now: u64) -> (char, String, String) {
    let on = Value::Bool(now % 3 == 1);
    assert!(stand.tree.local_mut().set(0, on));
    let (answer, log) = stand.tick(now);
    (answer, log, stand.letters())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn a_tree_made_from_its_record_goes_on(plan in plans(), at in prop::collection::vec(any::<bool>(), 20)) {
        let mut whole = stand(&plan);
        let mut killed = stand(&plan);
        for (now, kill) in (0..).zip(at) {
            prop_assert_eq!(tick(&mut whole, now), tick(&mut killed, now));
            prop_assert_eq!(whole.tree.events(), killed.tree.events());
            prop_assert_eq!(whole.tree.tip(), killed.tree.tip());
            if kill {
                killed.kill(|| stand(&plan));
            }
        }
    }

    #[test]
    fn damaged_records_are_refused_or_taken_but_never_fatal(
        plan in plans(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..20),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut stand = stand(&plan);
        (0..5).for_each(|now| { tick(&mut stand, now); });
        let mut record = Vec::new();
        stand.tree.save(&mut record);
        for (place, byte) in changes {
            let place = place.index(record.len());
            record[place] = byte;
        }
        if let Some(cut) = cut {
            record.truncate(cut.index(record.len()));
        }
        let before = stand.letters();
        if stand.tree.restore(&record).is_err() {
            prop_assert_eq!(before, stand.letters());
        }
        (5..25).for_each(|now| { tick(&mut stand, now); });
    }

    #[test]
    fn any_bytes_are_no_record(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let mut stand = Stand::new(act("a", "RS"), Board::new());
        prop_assert!(stand.tree.restore(&bytes).is_err());
        prop_assert!(stand.shared.restore(&bytes).is_err());
    }
}

#[test]
fn state_survives_an_edited_tree_by_the_ids_of_the_nodes() {
    let old = vec![act("a", "S"), act("b", "RRS"), act("c", "S")];
    let mut stand = Stand::new(Node::sequence("root", Memory::Yes, old), Board::new());
    stand.tick(0);
    let mut record = Vec::new();
    stand.tree.save(&mut record);

    let new = vec![act("x", "S"), act("b", "RRS"), act("y", "S")];
    let mut edited = Stand::new(Node::sequence("root", Memory::Yes, new), Board::new());
    let carried = edited.tree.restore(&record).unwrap();
    assert_eq!((carried.nodes, carried.lost), (2, 2));
    assert_eq!(edited.tick(1), ('R', "b R".to_owned()));
    assert_eq!(edited.tick(2), ('S', "b S, y starts, y S".to_owned()));

    let gone = vec![act("x", "S"), act("y", "R")];
    let mut edited = Stand::new(Node::sequence("root", Memory::Yes, gone), Board::new());
    edited.tree.restore(&record).unwrap();
    assert_eq!(edited.tick(1).1, "x starts, x S, y starts, y R");
}

#[test]
fn the_time_between_ticks_and_deadlines_are_in_the_record() {
    let make = || {
        Stand::new(
            act("a", "R").with(Modifier::Timeout(In::Literal(1.0))),
            Board::new(),
        )
    };
    let mut stand = make();
    stand.tick(500);
    stand.kill(make);
    assert_eq!(stand.answer(1500), 'R');
    stand.kill(make);
    assert_eq!(stand.answer(1501), 'F');
}
