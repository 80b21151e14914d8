//! A file without its host: every name of a guard, callback or sub-behaviour
//! counts as known.

use std::collections::BTreeSet;

use super::definition::{Definition, Name, StateDef};
use super::ids::Vocabulary;
use super::problem::Problems;
use super::table::Table;

impl Definition {
    /// Compiles without a host, to draw and to check. States and triggers have to be right;
    /// the names of guards and callbacks cannot be checked here.
    /// here.
    ///
    /// # Errors
    /// As [`Definition::compile`].
    pub fn compile_alone(&self) -> Result<Table, Problems> {
        let mut names = Names::default();
        names.of_machine(self);
        self.states.iter().for_each(|state| names.of_state(state));
        self.compile(&Vocabulary {
            triggers: &[],
            guards: &names.guards.names,
            callbacks: &names.callbacks.names,
            behaviors: &names.behaviors.names,
        })
    }
}

#[derive(Default)]
struct Names<'d> {
    guards: Once<'d>,
    callbacks: Once<'d>,
    behaviors: Once<'d>,
}

/// Names in the order of their first use, each once.
#[derive(Default)]
pub(crate) struct Once<'d> {
    pub(crate) names: Vec<&'d str>,
    seen: BTreeSet<&'d str>,
}

impl<'d> Once<'d> {
    pub(crate) fn add(&mut self, names: &'d [Name]) {
        for name in names {
            if self.seen.insert(&name.text) {
                self.names.push(&name.text);
            }
        }
    }
}

impl<'d> Names<'d> {
    fn of_machine(&mut self, machine: &'d Definition) {
        for row in &machine.rows {
            self.guards.add(&row.conditions);
            self.guards.add(&row.unless);
            self.callbacks.add(&row.prepare);
            self.callbacks.add(&row.before);
            self.callbacks.add(&row.after);
        }
        for chain in &machine.ordered {
            self.guards.add(&chain.conditions);
            self.guards.add(&chain.unless);
        }
        self.callbacks.add(&machine.prepare_event);
        self.callbacks.add(&machine.before_state_change);
        self.callbacks.add(&machine.after_state_change);
        self.callbacks.add(&machine.finalize_event);
        self.callbacks.add(&machine.on_final);
    }

    fn of_state(&mut self, state: &'d StateDef) {
        self.callbacks.add(&state.enter);
        self.callbacks.add(&state.exit);
        let runs = state.during.iter().map(|during| &during.run);
        runs.for_each(|run| self.behaviors.add(std::slice::from_ref(run)));
        state.children.iter().for_each(|child| self.of_state(child));
    }
}
