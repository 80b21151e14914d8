//! Probable mistakes in a matrix that is valid.

use super::ids::EventId;
use super::table::Table;
use crate::Finding;
use crate::machine::set::SmallSet;
use crate::machine::{Final, StateId};

/// Finds states that cannot be reached or left, unhandled events, and
/// states from which no final state can be reached.
pub fn check(table: &Table) -> Vec<Finding> {
    let next = successors(table);
    let reachable = closure(&next, table.initial.index());
    let mut found = Vec::new();
    for (at, state) in table.states.iter().enumerate() {
        let mut add = |rule, message: &str| {
            found.push(Finding {
                rule,
                place: state.name.clone(),
                message: message.to_owned(),
            });
        };
        let ahead = closure(&next, at);
        let mut ends = ahead.iter().filter_map(|at| table.states.get(at));
        // One finding per state, the most serious first: a state that is not reached is a dead
        // end for that reason.
        if !reachable.contains(at) {
            add(
                "unreachable_state",
                "no cell leads here from the initial state; declare it in a goto or drop it",
            );
        } else if state.end == Final::No && ahead.len() == 1 {
            add(
                "dead_end",
                "no cell leads out of this state; declare where its handlers go, or say final = true",
            );
        } else if has_final(table) && ends.all(|state| state.end == Final::No) {
            add(
                "never_final",
                "no final state can be reached from here; add a way to one",
            );
        }
    }
    for event in &table.order {
        // Only reachable states count: a handler in another one never runs.
        let mut states = reachable.iter();
        if states.all(|at| table.cell(StateId::of(at), *event).is_none()) {
            found.push(Finding {
                rule: "unhandled_event",
                place: table.event_name(*event).to_owned(),
                message: "no reachable state handles this event; fill in a cell or drop it"
                    .to_owned(),
            });
        }
    }
    found
}

/// As [`check`]; the work of the states `ends` ends the job, so they need no cell.
pub fn check_with_ends(table: &Table, ends: &[StateId]) -> Vec<Finding> {
    let mut table = table.clone();
    for state in ends {
        if let Some(state) = table.states.get_mut(state.index()) {
            state.end = Final::Failure;
        }
    }
    check(&table)
}

fn has_final(table: &Table) -> bool {
    table.states.iter().any(|state| state.end != Final::No)
}

/// For each state, the states to which its cells lead.
fn successors(table: &Table) -> Vec<SmallSet> {
    let states = (0..table.states.len()).map(StateId::of);
    let next = states.map(|state| {
        let cells = table.order.iter().filter_map(|it| table.cell(state, *it));
        let goto = cells.flat_map(|cell| &cell.goto);
        goto.map(|state| state.index()).collect()
    });
    next.collect()
}

/// The state `from` and all that can be reached from it.
fn closure(next: &[SmallSet], from: usize) -> SmallSet {
    let mut known = SmallSet::from_iter([from]);
    let mut open = vec![from];
    while let Some(at) = open.pop() {
        let ahead = next.get(at).copied().unwrap_or_default();
        open.extend(ahead.difference(&known).iter());
        known = known.union(&ahead);
    }
    known
}

/// For each event, the states in which it has no effect.
pub fn unhandled(table: &Table) -> Vec<(EventId, Vec<StateId>)> {
    let all = table.order.iter().map(|event| {
        let states = (0..table.states.len()).map(StateId::of);
        let deaf = states.filter(|state| table.cell(*state, *event).is_none());
        (*event, deaf.collect::<Vec<_>>())
    });
    all.filter(|(_, states)| !states.is_empty()).collect()
}
