//! The matrix of events and states.

use std::error::Error;
use std::hint::black_box;

use behavior::machine::Fault;
use behavior::matrix::{Cell, Definition, EventSet, HandlerId, Handlers, Matrix, Next, Vocabulary};

use super::subject::Subject;

/// The matrix of an example of the library.
const FILL_BIN: &str = include_str!("../../../crates/core/behavior/examples/fill_bin.toml");
const HANDLERS: [&str; 8] = [
    "to_above_bin",
    "resume",
    "to_surface",
    "close_gripper",
    "lift",
    "ask_for_parts",
    "give_up",
    "aim_again",
];
/// Pending events, step by step: one bin, picked and lost again.
const STEPS: [&[&str]; 5] = [
    &["START", "NONE"],
    &["NONE"],
    &["GOAL_REACHED", "NONE"],
    &["ATTACHED", "NONE"],
    &["DETACHED", "GOAL_REACHED", "NONE"],
];

/// Goes to the first state of its cell.
struct Follow;

impl Handlers for Follow {
    fn handle(&mut self, _: HandlerId, cell: Cell<'_>) -> Result<Next, Fault> {
        Ok(cell.goto.first().copied().map_or(Next::Stay, Next::Goto))
    }
}

/// A step of the matrix, the choice among the pending events included.
pub(crate) fn subjects() -> Result<Vec<Subject>, Box<dyn Error>> {
    let vocabulary = Vocabulary {
        handlers: &HANDLERS,
        ..Vocabulary::default()
    };
    let table = Definition::load("fill_bin.toml", FILL_BIN, &vocabulary)?;
    let mut matrix = Matrix::new(table.into());
    let mut steps = Vec::new();
    for names in STEPS {
        let mut pending = EventSet::EMPTY;
        for name in names {
            let event = matrix.table().event(name).ok_or("no such event")?;
            pending = pending.with(event);
        }
        steps.push(pending);
    }
    let mut next = 0;
    Ok(vec![Subject::new(
        "matrix, filling a bin: step",
        move |times| {
            for _ in 0..times {
                let Some(pending) = steps.get(next) else {
                    return;
                };
                next = (next + 1) % steps.len();
                matrix.clear_trace();
                let handled = matrix.tick(black_box(*pending), &mut Follow);
                assert!(handled.is_ok(), "{handled:?}");
                black_box(matrix.state());
            }
        },
    )])
}
