//! A small library of leaves, and a file that uses everything.

#![allow(dead_code, reason = "each test uses a part")]
#![allow(clippy::unwrap_used, clippy::result_large_err, reason = "in tests")]

use std::collections::BTreeMap;

use behavior::board::{Board, Fault, In, Out};
use behavior::descriptor::{self, Errors, Read, Source};
use behavior::tree::{Cx, Host, Leaf, Library, NodeType};
use behavior::{Status, Str, Value};

pub(crate) struct Toy;

impl Host for Toy {
    type World<'w> = Vec<String>;
}

pub(crate) struct Move {
    target: In<[f64; 3]>,
    speed: In<f64>,
}

impl Leaf<Toy> for Move {
    type State = u32;

    fn start(&self, ticks: &mut u32, _: &mut Cx<'_, '_, Toy>) -> Result<(), Fault> {
        *ticks = 0;
        Ok(())
    }

    fn tick(&self, ticks: &mut u32, cx: &mut Cx<'_, '_, Toy>) -> Result<Status, Fault> {
        let (target, speed) = (cx.get(&self.target)?, cx.get(&self.speed)?);
        cx.world.push(format!("move {target:?} {speed}"));
        *ticks += 1;
        Ok(if *ticks < 2 {
            Status::Running
        } else {
            Status::Success
        })
    }
}

pub(crate) struct Pick(Out<Str>);

impl Leaf<Toy> for Pick {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Toy>) -> Result<Status, Fault> {
        cx.set(&self.0, Str::new("red").unwrap())?;
        Ok(Status::Success)
    }
}

pub(crate) struct Seen(In<Str>);

impl Leaf<Toy> for Seen {
    type State = ();

    fn tick(&self, (): &mut (), cx: &mut Cx<'_, '_, Toy>) -> Result<Status, Fault> {
        let seen = !cx.get(&self.0)?.is_empty();
        Ok(if seen {
            Status::Success
        } else {
            Status::Failure
        })
    }
}

pub(crate) fn library() -> Library<Toy> {
    let moves = NodeType::new("MoveTo", "Moves the hand", |b| {
        Ok(Move {
            target: b.input("target")?,
            speed: b.input("speed")?,
        })
    });
    let pick = NodeType::new("PickNext", "Chooses a thing", |b| {
        Ok(Pick(b.output("thing")?))
    });
    let seen = NodeType::new("IsSeen", "Whether it is seen", |b| {
        Ok(Seen(b.input("thing")?))
    });
    Library::default()
        .with(
            moves
                .aliases(&["Goto"])
                .keywords(&["reach", "travel"])
                .drives("hand")
                .input::<[f64; 3]>("target", "Position, m")
                .input_or::<f64>("speed", 0.5, "Speed, m/s")
                .within(0.0, 2.0),
        )
        .with(
            pick.keywords(&["choose"])
                .output::<Str>("thing", "Its name"),
        )
        .with(
            seen.keywords(&["condition"])
                .input::<Str>("thing", "Its name")
                .one_of(&["red", "blue"]),
        )
}

pub(crate) fn read(text: &str) -> Result<Read<Toy>, Errors> {
    read_with(text, &BTreeMap::new(), &|_| Err(String::new()))
}

pub(crate) fn read_with(
    text: &str,
    constants: &BTreeMap<String, Value>,
    include: &descriptor::Include<'_>,
) -> Result<Read<Toy>, Errors> {
    let source = Source {
        file: "t.json",
        text,
        include,
    };
    descriptor::read(&source, &library(), constants, &Board::new())
}

/// A file that is right and uses every part of the format.
pub(crate) const GOOD: &str = include_str!("good.tree.json");
