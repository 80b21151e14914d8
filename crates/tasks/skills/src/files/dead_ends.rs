//! Check for states that a run would never leave.

use std::collections::BTreeSet;

use behavior::inline::Inline;
use behavior::machine::{Definition, Final, StateId, Table};

use crate::nodes;

/// States whose last step fails the job: they need no exit.
pub(super) fn ends(inline: &Inline, state: impl Fn(&str) -> Option<StateId>) -> Vec<StateId> {
    let parts = inline.states.iter();
    let parts = parts.filter(|part| part.last_type() == Some(nodes::FAIL_JOB));
    parts.filter_map(|part| state(&part.name)).collect()
}

/// The triggers that are fired in a machine.
pub(super) struct Fired<'a> {
    /// Conditions, by name.
    pub(super) events: &'a [&'a str],
    /// States that fail the job.
    pub(super) ends: &'a [StateId],
}

impl Fired<'_> {
    /// Refuses a state that a run would never leave: the job would wait there until its time
    /// limit.
    pub(super) fn refuse_dead_ends(
        &self,
        definition: &Definition,
        table: &Table,
    ) -> Result<(), String> {
        for state in &definition.states {
            let id = table.state(&state.name.text);
            let gives_up = id.is_some_and(|id| self.ends.contains(&id));
            // Final states end the run, and a state with children is left by rows of its
            // children.
            if state.end != Final::No || !state.children.is_empty() || gives_up {
                continue;
            }
            let results = state.during.iter().flat_map(|during| {
                let both = during.success.iter().chain(&during.failure);
                both.map(|name| name.text.as_str())
            });
            // Rows for other triggers exist in the table, too, but nothing would ever fire
            // them.
            let fired: BTreeSet<&str> = results.chain(self.events.iter().copied()).collect();
            let leaves = id.is_some_and(|id| {
                let mut triggers = table.triggers_of(id);
                triggers.any(|trigger| fired.contains(&table.trigger_name(trigger)))
            });
            if !leaves {
                let (file, name, place) = (&definition.file, &state.name.text, state.name.place);
                return Err(format!(
                    "{file}:{}:{}: nothing leaves state '{name}'; give it during.steps with a \
                     success that has a row, a row for one of [events], final = true, or \
                     FailJob as its last step",
                    place.line, place.column
                ));
            }
        }
        Ok(())
    }
}
