//! A state of a machine runs a tree, and a leaf of a tree runs a machine.

#![allow(clippy::unwrap_used, clippy::match_bool, reason = "helpers of tests")]

use std::time::Duration;

use behavior::board::{Board, Fault};
use behavior::machine::{
    self, Actions, BehaviorId, CallbackId, Definition, Event, Final, GuardId, Machine, RowDef,
    StateDef, Vocabulary,
};
use behavior::status::ResetReason;
use behavior::tree::{Cx, Halt, Host, Leaf, Memory, Node, Tree};
use behavior::{NodeStatus, Status};

/// A world of one machine and a list of what the leaves did.
struct World {
    inner: Machine,
    answer: Status,
    log: Vec<&'static str>,
}

struct Nested;

impl Host for Nested {
    type World<'w> = World;
}

/// Answers what the world says, and takes two ticks to stop.
struct Work;

impl Leaf<Nested> for Work {
    type State = u32;

    fn tick(&self, _: &mut u32, cx: &mut Cx<'_, '_, Nested>) -> Result<Status, Fault> {
        cx.world.log.push("work");
        Ok(cx.world.answer)
    }

    fn halt(&self, asked: &mut u32, cx: &mut Cx<'_, '_, Nested>, _: ResetReason) -> Halt {
        cx.world.log.push("halt");
        *asked += 1;
        if *asked < 2 { Halt::NotYet } else { Halt::Done }
    }
}

/// Steps the machine of the world; done when that is.
struct RunMachine;

impl Leaf<Nested> for RunMachine {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Nested>) -> Result<Status, Fault> {
        let inner = &mut cx.world.inner;
        let next = inner.table().trigger("next").unwrap();
        if inner.status() == Status::Running {
            inner.trigger(next, &mut Silent).unwrap();
        }
        Ok(inner.status())
    }
}

struct Silent;

impl Actions for Silent {
    fn guard(&mut self, _: GuardId) -> bool {
        true
    }

    fn call(&mut self, _: CallbackId, _: &mut Event<'_>) -> Result<(), machine::Fault> {
        Ok(())
    }
}

fn inner() -> Machine {
    let chain = Definition::new("inner")
        .states(&["one", "two"])
        .state(StateDef::new("three").end(Final::Success))
        .ordered("next", &["one", "two", "three"], false);
    Machine::new(chain.compile(&Vocabulary::default()).unwrap().into())
}

fn world() -> World {
    World {
        inner: inner(),
        answer: Status::Running,
        log: Vec::new(),
    }
}

fn tree(leaf: impl Leaf<Nested>) -> Tree<Nested> {
    let root = Node::sequence("root", Memory::Yes, vec![Node::leaf("leaf", "Leaf", leaf)]);
    Tree::new("tree", root, Board::new()).unwrap()
}

struct Outer {
    tree: Tree<Nested>,
    shared: Board,
    world: World,
}

impl Actions for Outer {
    fn guard(&mut self, _: GuardId) -> bool {
        true
    }

    fn call(&mut self, _: CallbackId, _: &mut Event<'_>) -> Result<(), machine::Fault> {
        Ok(())
    }

    fn run(&mut self, _: BehaviorId) -> Status {
        self.tree
            .tick(Duration::ZERO, &mut self.shared, &mut self.world)
    }

    fn halt(&mut self, _: BehaviorId, reason: ResetReason) -> bool {
        let (shared, world) = (&mut self.shared, &mut self.world);
        self.tree.reset(reason, Duration::ZERO, shared, world) == Halt::Done
    }
}

#[test]
fn a_state_runs_a_tree_fires_on_its_result_and_halts_it_on_leaving() {
    let vocabulary = Vocabulary {
        behaviors: &["tree"],
        ..Vocabulary::default()
    };
    let definition = Definition::new("outer")
        .state(StateDef::new("busy").during("tree", Some("done"), None))
        .states(&["rest"])
        .row(RowDef::new("done", "busy", "rest"))
        .row(RowDef::new("stop", "busy", "rest"))
        .row(RowDef::new("go", "rest", "busy"));
    let mut machine = Machine::new(definition.compile(&vocabulary).unwrap().into());
    let mut outer = Outer {
        tree: tree(Work),
        shared: Board::new(),
        world: world(),
    };
    let trigger = |name: &str| machine.table().trigger(name).unwrap();
    let (stop, go) = (trigger("stop"), trigger("go"));

    machine.tick(&mut outer).unwrap();
    assert_eq!(outer.tree.status(), NodeStatus::Running);
    machine.trigger(stop, &mut outer).unwrap();
    machine.trigger(go, &mut outer).unwrap();
    machine.tick(&mut outer).unwrap();
    assert_eq!(
        outer.world.log,
        ["work", "halt", "halt", "work"],
        "waits until it has stopped"
    );

    outer.world.answer = Status::Success;
    machine.tick(&mut outer).unwrap();
    assert_eq!(machine.state_name(), "rest");
    assert_eq!(
        outer.world.log.last(),
        Some(&"work"),
        "what is done is not halted"
    );
}

#[test]
fn a_leaf_runs_a_machine_which_goes_on_from_its_record() {
    let (mut world, mut shared) = (world(), Board::new());
    let mut first = tree(RunMachine);
    assert_eq!(
        first.tick(Duration::ZERO, &mut shared, &mut world),
        Status::Running
    );
    assert_eq!(world.inner.state_name(), "two");
    let (mut of_tree, mut of_machine) = (Vec::new(), Vec::new());
    first.save(&mut of_tree);
    world.inner.save(&mut of_machine);

    let mut second = tree(RunMachine);
    world.inner = inner();
    second.restore(&of_tree).unwrap();
    world.inner.restore(&of_machine).unwrap();
    assert_eq!(
        second.tick(Duration::ZERO, &mut shared, &mut world),
        Status::Success
    );
    assert_eq!(world.inner.state_name(), "three");
}
