//! What is legal in a matrix, but probably not meant.

use super::ids::EventId;
use super::table::Table;
use crate::Finding;
use crate::machine::set::SmallSet;
use crate::machine::{Final, StateId};

/// Looks for states that cannot be reached or left, unhandled events, and
/// states from which no final state can be reached.
pub fn check(table: &Table) -> Vec<Finding> {
    let reachable = closure(table, SmallSet::from_iter([table.initial.index()]));
    let mut found = Vec::new();
    for (at, state) in table.states.iter().enumerate() {
        let mut add = |rule, message: &str| {
            found.push(Finding {
                rule,
                place: state.name.clone(),
                message: message.to_owned(),
            });
        };
        let ahead = closure(table, SmallSet::from_iter([at]));
        let mut ends = ahead.iter().filter_map(|at| table.states.get(at));
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

fn has_final(table: &Table) -> bool {
    table.states.iter().any(|state| state.end != Final::No)
}

/// States that can be reached from `known`, and those themselves.
fn closure(table: &Table, mut known: SmallSet) -> SmallSet {
    loop {
        let mut next = known;
        for at in known.iter() {
            for event in &table.order {
                let cell = table.cell(StateId::of(at), *event);
                let goto = cell.map(|cell| cell.goto.as_slice()).unwrap_or_default();
                for to in goto {
                    next.insert(to.index());
                }
            }
        }
        if next == known {
            return known;
        }
        known = next;
    }
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
