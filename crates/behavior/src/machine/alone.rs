//! A file without its host: every name of a guard, callback or sub-behaviour
//! is taken for known.

use super::definition::{Definition, Name, StateDef};
use super::ids::Vocabulary;
use super::problem::Problems;
use super::table::Table;

impl Definition {
    /// Compiles without a host, to look at and to check. States and triggers
    /// have to be right; what the guards and callbacks are called is not known
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
            guards: &names.guards,
            callbacks: &names.callbacks,
            behaviors: &names.behaviors,
        })
    }
}

#[derive(Default)]
struct Names<'d> {
    guards: Vec<&'d str>,
    callbacks: Vec<&'d str>,
    behaviors: Vec<&'d str>,
}

impl<'d> Names<'d> {
    fn of_machine(&mut self, machine: &'d Definition) {
        for row in &machine.rows {
            add(&mut self.guards, &row.conditions);
            add(&mut self.guards, &row.unless);
            add(&mut self.callbacks, &row.prepare);
            add(&mut self.callbacks, &row.before);
            add(&mut self.callbacks, &row.after);
        }
        for chain in &machine.ordered {
            add(&mut self.guards, &chain.conditions);
            add(&mut self.guards, &chain.unless);
        }
        add(&mut self.callbacks, &machine.prepare_event);
        add(&mut self.callbacks, &machine.before_state_change);
        add(&mut self.callbacks, &machine.after_state_change);
        add(&mut self.callbacks, &machine.finalize_event);
        add(&mut self.callbacks, &machine.on_final);
    }

    fn of_state(&mut self, state: &'d StateDef) {
        add(&mut self.callbacks, &state.enter);
        add(&mut self.callbacks, &state.exit);
        let runs = state.during.iter().map(|during| &during.run);
        runs.for_each(|run| add(&mut self.behaviors, std::slice::from_ref(run)));
        state.children.iter().for_each(|child| self.of_state(child));
    }
}

/// Adds each name once.
pub(crate) fn add<'d>(known: &mut Vec<&'d str>, names: &'d [Name]) {
    for name in names {
        if !known.contains(&name.text.as_str()) {
            known.push(&name.text);
        }
    }
}
