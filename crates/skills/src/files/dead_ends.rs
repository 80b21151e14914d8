//! States that a run would never leave.

use std::collections::BTreeSet;

use behavior::inline::Inline;
use behavior::machine::{Definition, Final, StateId, Table};

use crate::nodes;

/// States whose last step gives the job up: nothing has to leave them.
pub(super) fn ends(inline: &Inline, state: impl Fn(&str) -> Option<StateId>) -> Vec<StateId> {
    let parts = inline.states.iter();
    let parts = parts.filter(|part| part.last_type() == Some(nodes::FAIL_JOB));
    parts.filter_map(|part| state(&part.name)).collect()
}

/// What takes a machine out of its states.
pub(super) struct Fired<'a> {
    /// Conditions, by name.
    pub(super) events: &'a [&'a str],
    /// States that give the job up.
    pub(super) ends: &'a [StateId],
}

impl Fired<'_> {
    /// Refuses a state that a run would never leave.
    pub(super) fn refuse_dead_ends(
        &self,
        definition: &Definition,
        table: &Table,
    ) -> Result<(), String> {
        for state in &definition.states {
            let id = table.state(&state.name.text);
            let gives_up = id.is_some_and(|id| self.ends.contains(&id));
            if state.end != Final::No || !state.children.is_empty() || gives_up {
                continue;
            }
            let results = state.during.iter().flat_map(|during| {
                let both = during.success.iter().chain(&during.failure);
                both.map(|name| name.text.as_str())
            });
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
