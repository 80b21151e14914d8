//! After load nothing of a machine or a matrix uses the heap.

#![allow(clippy::unwrap_used, clippy::match_bool, reason = "helpers of tests")]

use crate::machine_host;

use std::hint::black_box;

use behavior::machine::{
    Actions, CallbackId, Definition, Event, Fault, GuardId, Machine, RowDef, StateDef, names,
};
use behavior::matrix::{self, EventSet, Handlers, Matrix, Next};
use cell_rt::alloc::count;
use machine_host::machine;

fn allocations(work: impl FnOnce()) -> u64 {
    let before = count();
    work();
    count() - before
}

/// Allocates nothing itself, so that only allocations of the engine are counted.
struct Quiet(u64);

impl Actions for Quiet {
    fn guard(&mut self, _: GuardId) -> bool {
        self.0 += 1;
        self.0.is_multiple_of(3)
    }

    fn call(&mut self, _: CallbackId, event: &mut Event<'_>) -> Result<(), Fault> {
        self.0 += 1;
        match self.0 % 7 {
            0 => Err(Fault {
                reason: "now and then",
            }),
            3 => Ok(event.post(event.trigger)?),
            _ => Ok(()),
        }
    }
}

impl Handlers for Quiet {
    fn handle(&mut self, _: matrix::HandlerId, cell: matrix::Cell<'_>) -> Result<Next, Fault> {
        self.0 += 1;
        Ok(cell.goto.first().map_or(Next::Stay, |to| Next::Goto(*to)))
    }
}

fn busy() -> Machine {
    let inner = || {
        vec![
            StateDef::new("a").enter(&["enter"]),
            StateDef::new("b").during("carry", Some("t"), None),
        ]
    };
    let region = |name: &str| StateDef::new(name).children("a", inner()).exit(&["exit"]);
    let mut definition = Definition::new("busy")
        .state(StateDef::new("P").regions(vec![region("1"), region("2")]))
        .state(StateDef::new("Q").children("b", inner()))
        .row(
            RowDef::new("t", "P.1.a", "P.1.b")
                .when(&["x"])
                .after(&["after"]),
        )
        .row(RowDef::new("t", "P.2.a", "P.2.b"))
        .row(RowDef::new("t", "P", "Q").unless(&["x", "y"]))
        .row(RowDef::new("t", "Q", "P").prepare(&["prep"]))
        .row(RowDef::new("u", "*", "=").before(&["before"]));
    definition.finalize_event = names(&["finalize"]);
    machine(&definition)
}

#[test]
fn triggers_ticks_records_and_traces_use_no_heap() {
    let mut machine = busy();
    let triggers = ["t", "u"].map(|name| machine.table().trigger(name).unwrap());
    let mut host = Quiet(0);
    let mut record = Vec::with_capacity(machine.record_bytes());
    let mut visited = 0;
    let used = allocations(|| {
        for round in 0..2_000 {
            black_box(machine.may(triggers[round % 2], &mut host));
            black_box(machine.trigger(triggers[round % 2], &mut host)).ok();
            black_box(machine.tick(&mut host)).ok();
            visited += machine.active().count() + machine.statuses().count();
            record.clear();
            machine.save(&mut record);
            machine.restore(&record).ok();
            if round % 5 == 0 {
                machine.clear_trace();
            }
        }
    });
    assert_eq!(used, 0);
    assert!(visited > 0 && machine.trace().len() <= behavior::machine::TRACE_CAPACITY);
}

#[test]
fn steps_of_a_matrix_use_no_heap() {
    let table = matrix::Definition::new("m", &["A", "B"], &["S", "T"])
        .idle("B")
        .cell(matrix::CellDef::new("S", "A", "h").goto(&["T"]))
        .cell(matrix::CellDef::new("T", "B", "h").goto(&["S"]));
    let known = matrix::Vocabulary {
        handlers: &["h"],
        ..matrix::Vocabulary::default()
    };
    let mut matrix = Matrix::new(table.compile(&known).unwrap().into());
    let pending = EventSet::EMPTY.with(matrix.table().event("A").unwrap());
    let mut host = Quiet(0);
    let mut record = Vec::with_capacity(matrix.record_bytes());
    let used = allocations(|| {
        for round in 0..1_000 {
            let events = if round % 2 == 0 {
                pending
            } else {
                EventSet::EMPTY
            };
            black_box(matrix.tick(events, &mut host)).ok();
            record.clear();
            matrix.save(&mut record);
            matrix.restore(&record).ok();
        }
    });
    assert_eq!((used, host.0), (0, 1_000));
}
