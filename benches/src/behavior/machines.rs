//! Our machines, event by event.

use std::error::Error;
use std::hint::black_box;

use behavior::machine::{
    Actions, CallbackId, Definition, Event, Fault, GuardId, Machine, RowDef, TriggerId, Vocabulary,
};

use super::subject::Subject;

/// Row of the ring of phases.
pub const PHASES: &str = "machine, 8 phases: event";
/// Row of the palletizing table.
pub const PALLETIZING: &str = "machine, palletizing: event";

/// The table of an example of the library.
const TABLE: &str = include_str!("../../../crates/core/behavior/examples/palletizing.toml");
/// One bin: turned over, picked again, placed.
const BIN: [&str; 5] = [
    "go_pick",
    "pick_done",
    "flip_done",
    "pick_done",
    "place_done",
];
const STATES: [&str; 8] = [
    "pre_grasp",
    "approach",
    "grasp",
    "lift",
    "transport",
    "lower",
    "release",
    "retract",
];

/// Every other bin is upside down; the layer is never full.
#[derive(Default)]
struct Bins {
    flipped: bool,
}

impl Actions for Bins {
    fn guard(&mut self, guard: GuardId) -> bool {
        // In the order of the vocabulary: needs_flip is the first.
        self.flipped ^= guard.index() == 0;
        self.flipped && guard.index() == 0
    }

    fn call(&mut self, _: CallbackId, _: &mut Event<'_>) -> Result<(), Fault> {
        Ok(())
    }
}

/// A ring of phases, and the palletizing table.
pub(crate) fn subjects() -> Result<Vec<Subject>, Box<dyn Error>> {
    let mut ring = Definition::new("phases").states(&STATES);
    for (phase, next) in STATES.iter().zip(STATES.iter().cycle().skip(1)) {
        ring = ring.row(RowDef::new("done", phase, next));
    }
    let ring = Machine::new(ring.compile(&Vocabulary::default())?.into());
    let vocabulary = Vocabulary {
        guards: &["needs_flip", "placement_completes_stack"],
        ..Vocabulary::default()
    };
    let table = Definition::load("palletizing.toml", TABLE, &vocabulary)?;
    let palletizing = Machine::new(table.into());
    Ok(vec![
        subject(PHASES, ring, &["done"])?,
        subject(PALLETIZING, palletizing, &BIN)?,
    ])
}

fn subject(
    name: &'static str,
    mut machine: Machine,
    events: &[&str],
) -> Result<Subject, Box<dyn Error>> {
    let known = |name: &&str| machine.table().trigger(name);
    let triggers: Option<Vec<TriggerId>> = events.iter().map(known).collect();
    let triggers = triggers.ok_or("a trigger is not in its table")?;
    let (mut bins, mut next) = (Bins::default(), 0);
    Ok(Subject::new(name, move |times| {
        for _ in 0..times {
            let Some(trigger) = triggers.get(next) else {
                return;
            };
            next = (next + 1) % triggers.len();
            // Lines of the trace are read after each event in a task as well.
            machine.clear_trace();
            let fired = machine.trigger(*trigger, &mut bins);
            assert!(fired.is_ok(), "{fired:?} in {}", machine.state_name());
            black_box(machine.state());
        }
    }))
}
