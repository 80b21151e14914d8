//! Probable mistakes in a machine that is valid.

use std::collections::BTreeSet;

use super::definition::Final;
use super::ids::{StateId, TriggerId};
use super::set::SmallSet;
use super::table::{Condition, Row, State, Table};
use crate::Finding;

/// Number of earlier rows of one trigger and source with which a row is compared: each with
/// each would take minutes in the largest table.
const COMPARED: usize = 256;

/// Finds states that cannot be reached or left, rows that are never taken, and triggers
/// without effect. Guards are assumed to be independent of one another.
pub fn check(table: &Table) -> Vec<Finding> {
    let reachable = reachable(table);
    let mut found = Vec::new();
    found.extend(unreachable_states(table, &reachable));
    found.extend(dead_ends(table, &reachable));
    found.extend(endless(table, &reachable));
    found.extend(rows(table));
    found.extend(unused_triggers(table, &reachable));
    found
}

/// As [`check`]; the work of the states `ends` ends the job, so they need no row.
pub fn check_with_ends(table: &Table, ends: &[StateId]) -> Vec<Finding> {
    let mut table = table.clone();
    // Of any kind: the checks only compare with `Final::No`.
    for state in ends {
        if let Some(state) = table.states.get_mut(state.index()) {
            state.end = Final::Failure;
        }
    }
    check(&table)
}

fn finding(rule: &'static str, place: impl Into<String>, message: String) -> Finding {
    Finding {
        rule,
        place: place.into(),
        message,
    }
}

/// Rank and id of a source, and a destination.
type Transitions = BTreeSet<((usize, StateId), StateId)>;

/// Ranks of all states that can become active.
fn reachable(table: &Table) -> SmallSet {
    let none = SmallSet::default();
    let mut next = vec![none; table.states.len()];
    for ((source, _), dest) in transitions(table) {
        if let Some(ahead) = next.get_mut(source) {
            // Entering a state makes its whole configuration active, other regions included.
            *ahead = ahead.union(&table.configuration(dest, &none));
        }
    }
    let mut known = table.configuration(table.initial, &none);
    let mut open: Vec<usize> = known.iter().collect();
    while let Some(rank) = open.pop() {
        let ahead = next.get(rank).copied().unwrap_or_default();
        open.extend(ahead.difference(&known).iter());
        known = known.union(&ahead);
    }
    known
}

/// Sources and destinations of all rows, each pair once: a table may have many more rows than
/// pairs of states.
fn transitions(table: &Table) -> Transitions {
    let way = |row: &Row| {
        let source = table.get(row.source)?;
        Some(((source.rank, row.source), row.dest?))
    };
    table.rows.iter().filter_map(way).collect()
}

fn unreachable_states(table: &Table, reachable: &SmallSet) -> Vec<Finding> {
    let states = table.states.iter();
    let lost = states.filter(|state| !reachable.contains(state.rank));
    lost.map(|state| {
        let message = "no way leads here from the initial state; add a row or drop it".to_owned();
        finding("unreachable_state", &state.name, message)
    })
    .collect()
}

/// Whether a row leads from `state`, or from a state around it, to another state.
fn has_exit(table: &Table, transitions: &Transitions, state: &State) -> bool {
    transitions.iter().any(|((source, _), dest)| {
        let dest = table.get(*dest);
        // A destination that enters `state` again is not a way out.
        state.path.contains(*source) && dest.is_some_and(|dest| !dest.entry.contains(state.rank))
    })
}

fn innermost<'a>(table: &'a Table, reachable: &'a SmallSet) -> impl Iterator<Item = &'a State> {
    let states = table.states.iter();
    states.filter(|state| !state.has_children && reachable.contains(state.rank))
}

fn dead_ends(table: &Table, reachable: &SmallSet) -> Vec<Finding> {
    let open = innermost(table, reachable).filter(|state| state.end == Final::No);
    let transitions = transitions(table);
    open.filter(|state| !has_exit(table, &transitions, state))
        .map(|state| {
            let message = "no row leads out of this state; add one, or say final = true".to_owned();
            finding("dead_end", &state.name, message)
        })
        .collect()
}

/// States that can be left, but from which no final state can be reached; only for a
/// machine that has final states.
fn endless(table: &Table, reachable: &SmallSet) -> Vec<Finding> {
    let finals = table.states.iter().filter(|state| state.end != Final::No);
    let mut good: SmallSet = finals.map(|state| state.rank).collect();
    // Without final states the machine runs for ever on purpose.
    if good.is_empty() {
        return Vec::new();
    }
    let transitions = transitions(table);
    // Backwards from the final states until nothing is added.
    loop {
        let mut next = good;
        for ((_, source), dest) in &transitions {
            let dest = table.get(*dest);
            let ends = dest.is_some_and(|dest| !dest.entry.intersection(&good).is_empty());
            if ends && let Some(source) = table.get(*source) {
                next = next.union(&source.subtree);
            }
        }
        if next == good {
            break;
        }
        good = next;
    }
    innermost(table, reachable)
        // States without a way out are reported as dead ends already.
        .filter(|state| !good.contains(state.rank) && has_exit(table, &transitions, state))
        .map(|state| {
            let message = "no final state can be reached from here; add a way to one".to_owned();
            finding("never_final", &state.name, message)
        })
        .collect()
}

/// Rows after one that is always taken first, and rows with the same guards.
fn rows(table: &Table) -> Vec<Finding> {
    let mut found = Vec::new();
    let same_cell = |a: &Row, b: &Row| (a.trigger, a.source) == (b.trigger, b.source);
    // Rows are sorted by trigger and source, so those that compete are neighbours.
    for cell in table.rows.chunk_by(same_cell) {
        for (at, row) in cell.iter().enumerate() {
            let earlier = cell.get(..at.min(COMPARED)).unwrap_or_default();
            let Some(first) = earlier.iter().find(|it| covers(table, it, row)) else {
                continue;
            };
            let (rule, why) = match guards(table, first) {
                [] => ("shadowed_row", "asks no guard"),
                _ if guards(table, first).len() == guards(table, row).len() => {
                    ("same_guards", "asks the same guards")
                }
                _ => ("shadowed_row", "asks only some of its guards"),
            };
            let message = format!(
                "never taken for '{}' from '{}': {} comes first and {why}; change the order or the guards",
                table.trigger_name(row.trigger),
                table.state_name(row.source),
                table.row_name(first.id),
            );
            found.push(finding(rule, table.row_name(row.id), message));
        }
    }
    found
}

fn guards<'a>(table: &'a Table, row: &Row) -> &'a [Condition] {
    row.conditions.of(&table.conditions)
}

/// Whether `first` is taken whenever `row` could be: all its guards are guards of `row`.
fn covers(table: &Table, first: &Row, row: &Row) -> bool {
    let asked = guards(table, row);
    guards(table, first).iter().all(|it| asked.contains(it))
}

/// Triggers for which no reachable state has a row.
fn unused_triggers(table: &Table, reachable: &SmallSet) -> Vec<Finding> {
    let all = (0..table.triggers.len()).map(TriggerId::of);
    let unused = all.filter(|trigger| {
        let mut ranks = reachable.iter();
        !ranks.any(|rank| !table.rows_of(*trigger, rank).is_empty())
    });
    unused
        .map(|trigger| {
            let message = "no reachable state has a row for this trigger".to_owned();
            finding("unhandled_trigger", table.trigger_name(trigger), message)
        })
        .collect()
}

/// For each trigger, the reachable innermost states that refuse it: neither they nor the
/// states around them have a row for it.
pub fn unhandled(table: &Table) -> Vec<(TriggerId, Vec<StateId>)> {
    let reachable = reachable(table);
    let triggers = (0..table.triggers.len()).map(TriggerId::of);
    let refused = triggers.map(|trigger| {
        let states = innermost(table, &reachable);
        let deaf = states.filter(|state| {
            let mut path = state.path.iter();
            path.all(|rank| table.rows_of(trigger, rank).is_empty())
        });
        let ids = deaf.filter_map(|state| table.by_rank.get(state.rank).copied());
        (trigger, ids.collect::<Vec<_>>())
    });
    refused.filter(|(_, states)| !states.is_empty()).collect()
}
