//! Nested kinds of behaviour: a state of a machine runs a tree, and
//! a leaf of that tree runs another machine.
//!
//! `cargo run -p robocell-behavior --example nested`
#![allow(clippy::print_stdout, reason = "an example talks")]

use std::error::Error;
use std::time::Duration;

use behavior::Status;
use behavior::board::{Board, Fault};
use behavior::machine::{
    self, Actions, BehaviorId, CallbackId, Definition, Event, Final, GuardId, Machine, RowDef,
    StateDef, Vocabulary,
};
use behavior::status::ResetReason;
use behavior::tree::{Cx, Halt, Host, Leaf, Memory, Node, Tree};

/// The world of the leaves: a door with its own small machine, and a shelf.
struct Store {
    door: Machine,
    parcels: u32,
}

struct Courier;

impl Host for Courier {
    type World<'w> = Store;
}

/// The door has no guards and no callbacks.
struct Silent;

impl Actions for Silent {
    fn guard(&mut self, _: GuardId) -> bool {
        true
    }

    fn call(&mut self, _: CallbackId, _: &mut Event<'_>) -> Result<(), machine::Fault> {
        Ok(())
    }
}

/// A leaf that pushes the door through its states until it is open.
struct OpenDoor;

impl Leaf<Courier> for OpenDoor {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Courier>) -> Result<Status, Fault> {
        let door = &mut cx.world.door;
        if let Some(push) = door.table().trigger("push")
            && door.status() == Status::Running
            && door.trigger(push, &mut Silent).is_err()
        {
            return Ok(Status::Failure);
        }
        println!("    door is {}", door.state_name());
        Ok(door.status())
    }
}

/// A leaf that takes a parcel, if one is left.
struct TakeParcel;

impl Leaf<Courier> for TakeParcel {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Courier>) -> Result<Status, Fault> {
        let left = cx.world.parcels.checked_sub(1);
        cx.world.parcels = left.unwrap_or(0);
        Ok(left.map_or(Status::Failure, |_| Status::Success))
    }
}

/// The sub-behaviour of the outer machine: the tree, with its boards and world.
struct Work {
    tree: Tree<Courier>,
    shared: Board,
    store: Store,
    now: Duration,
}

impl Actions for Work {
    fn guard(&mut self, _: GuardId) -> bool {
        true
    }

    fn call(&mut self, _: CallbackId, _: &mut Event<'_>) -> Result<(), machine::Fault> {
        Ok(())
    }

    fn run(&mut self, _: BehaviorId) -> Status {
        self.tree.tick(self.now, &mut self.shared, &mut self.store)
    }

    fn halt(&mut self, _: BehaviorId, reason: ResetReason) -> bool {
        let tree = &mut self.tree;
        tree.reset(reason, self.now, &mut self.shared, &mut self.store) == Halt::Done
    }
}

fn door() -> Result<Machine, machine::Problems> {
    let door = Definition::new("door")
        .states(&["locked", "closed"])
        .state(StateDef::new("open").end(Final::Success))
        .row(RowDef::new("push", "locked", "closed"))
        .row(RowDef::new("push", "closed", "open"));
    Ok(Machine::new(door.compile(&Vocabulary::default())?.into()))
}

fn courier() -> Result<Machine, machine::Problems> {
    let vocabulary = Vocabulary {
        behaviors: &["fetch"],
        ..Vocabulary::default()
    };
    let courier = Definition::new("courier")
        .state(StateDef::new("fetching").during("fetch", Some("fetched"), Some("nothing_left")))
        .state(StateDef::new("delivering"))
        .state(StateDef::new("home").end(Final::Success))
        .row(RowDef::new("fetched", "fetching", "delivering"))
        .row(RowDef::new("delivered", "delivering", "fetching"))
        .row(RowDef::new("nothing_left", "fetching", "home"));
    Ok(Machine::new(courier.compile(&vocabulary)?.into()))
}

fn main() -> Result<(), Box<dyn Error>> {
    let steps = vec![
        Node::leaf("open", "OpenDoor", OpenDoor),
        Node::leaf("take", "TakeParcel", TakeParcel),
    ];
    let fetch = Node::sequence("fetch", Memory::Yes, steps);
    let mut work = Work {
        tree: Tree::new("fetch", fetch, Board::new())?,
        shared: Board::new(),
        store: Store {
            door: door()?,
            parcels: 2,
        },
        now: Duration::ZERO,
    };
    let mut courier = courier()?;
    let delivered = courier
        .table()
        .trigger("delivered")
        .ok_or("no such trigger")?;
    while courier.tick(&mut work)? == Status::Running {
        println!("{:?}: {}", work.now, courier.state_name());
        if courier.state_name() == "delivering" {
            courier.trigger(delivered, &mut work)?;
        }
        work.now += Duration::from_secs(1);
    }
    println!("{:?}: {}", work.now, courier.state_name());
    Ok(())
}
