//! Checks of rows for triggers that a host fires in many decisions in a row, while a
//! condition holds.

use super::ids::{StateId, TriggerId};
use super::set::SmallSet;
use super::table::{Row, Table};
use crate::Finding;

/// Number of states that one message names.
// A wildcard has a row for each state; a message with all of them would not be read.
const NAMED: usize = 3;

/// Finds rows of `events` that lead from a state into itself, and rows that lead in a
/// circle: a condition stays true while the state changes. Guards are assumed to be
/// independent of the conditions, so a circle with a guard is not reported.
pub fn check_events(table: &Table, events: &[&str]) -> Vec<Finding> {
    let mut found = Vec::new();
    for event in events {
        if let Some(trigger) = table.trigger(event) {
            found.extend(own_states(table, trigger, event));
            found.extend(circle(table, trigger, event));
        }
    }
    found
}

/// One finding for each declared row: a wildcard has a row for every state.
fn own_states(table: &Table, trigger: TriggerId, event: &str) -> Vec<Finding> {
    let again = |row: &&Row| {
        let source = table.get(row.source);
        let dest = row.dest.and_then(|dest| table.get(dest));
        let both = source.zip(dest);
        row.trigger == trigger && both.is_some_and(|(from, to)| from.path.contains(to.rank))
    };
    let mut rows: Vec<&Row> = table.rows.iter().filter(again).collect();
    rows.sort_by_key(|row| (row.id, row.source));
    let groups = rows.chunk_by(|a, b| a.id == b.id);
    let findings = groups.filter_map(|group| {
        let states: Vec<String> = group
            .iter()
            .take(NAMED)
            .map(|row| format!("'{}'", table.state_name(row.source)))
            .collect();
        let more = match group.len().saturating_sub(NAMED) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        Some(Finding {
            rule: "event_of_own_state",
            place: table.row_name(group.first()?.id),
            message: format!(
                "event '{event}' leads from {}{more} to a state that is active already: it is \
                 entered again when the condition becomes true, not while it stays true; \
                 leave it out of 'source', or keep the row if that is meant",
                states.join(", ")
            ),
        })
    });
    findings.collect()
}

/// The first circle of the rows of one event.
fn circle(table: &Table, trigger: TriggerId, event: &str) -> Option<Finding> {
    // `known` spans all starts: each state is followed once, so the search is linear.
    let mut known = SmallSet::default();
    for start in (0..table.states.len()).map(StateId::of) {
        let (mut way, mut state) = (vec![start], start);
        while let Some(next) = next(table, trigger, state) {
            if let Some(at) = way.iter().position(|it| *it == next) {
                return found(table, event, way.get(at..)?);
            }
            let rank = table.get(next)?.rank;
            if known.contains(rank) {
                break;
            }
            known.insert(rank);
            way.push(next);
            state = next;
        }
    }
    None
}

/// The destination of the event in `state`, if its row has no guard and leads to another state.
fn next(table: &Table, trigger: TriggerId, state: StateId) -> Option<StateId> {
    let active = table.configuration(state, &SmallSet::default());
    let mut ranks = active.iter();
    // The first row of the innermost state with one is the row that would be taken.
    let row = ranks.find_map(|rank| table.rows_of(trigger, rank).first())?;
    let dest = row
        .dest
        .filter(|_| row.conditions.of(&table.conditions).is_empty())?;
    let rank = table.get(dest)?.rank;
    (!active.contains(rank)).then_some(dest)
}

fn found(table: &Table, event: &str, circle: &[StateId]) -> Option<Finding> {
    let first = circle.first()?;
    let states = circle.iter().chain([first]);
    let names: Vec<&str> = states.map(|state| table.state_name(*state)).collect();
    Some(Finding {
        rule: "event_circle",
        place: table.state_name(*first).to_owned(),
        message: format!(
            "event '{event}' leads in a circle, {}: while its condition stays true the state \
             changes in every decision; add a guard to one of the rows",
            names.join(" -> ")
        ),
    })
}
