//! Compiles a definition into flat arrays; a name without a meaning is an error.

mod rows;
mod sizes;
mod states;

use super::definition::{Definition, Name};
use super::ids::{CallbackId, GuardId, StateId, TriggerId, Vocabulary};
use super::problem::{Collector, Location, Problems};
use super::set::MAX_MEMBERS;
use super::table::{Common, Condition, Row, Span, Table};
use crate::known::Known;

/// Largest number of rows after lists and wildcards are expanded.
// Rows have 16-bit ids; a short file with lists can multiply to more.
const MAX_ROWS: usize = 65_000;
/// Largest number of triggers.
// Well below 16 bits: the index has an entry for each trigger and state.
pub(crate) const MAX_TRIGGERS: usize = 4_096;

impl Definition {
    /// Compiles it for a host that knows `vocabulary`.
    ///
    /// # Errors
    /// All mistakes at once: names of states, guards, callbacks,
    /// sub-behaviours and triggers without a meaning, duplicates, limits.
    pub fn compile(&self, vocabulary: &Vocabulary<'_>) -> Result<Table, Problems> {
        // Sizes first: the checks below take time for each pair of some of these.
        self.check_sizes()?;
        let mut compiler = Compiler::new(self, vocabulary);
        compiler.check_host();
        compiler.add_states();
        // Without any state every row would be reported, which hides the one mistake.
        if compiler.problems.0.is_empty() || !compiler.states.names().is_empty() {
            compiler.add_rows();
        }
        let Compiler {
            problems,
            mut out,
            guards,
            callbacks,
            behaviors,
            triggers,
            ..
        } = compiler;
        out.guards = guards.into_names();
        out.callbacks = callbacks.into_names();
        out.behaviors = behaviors.into_names();
        out.triggers = triggers.into_names();
        out.row_lines.shrink_to_fit();
        problems.finish(&self.file, out)
    }
}

/// The state of the compiler.
struct Compiler<'a> {
    definition: &'a Definition,
    vocabulary: &'a Vocabulary<'a>,
    problems: Collector,
    out: Table,
    /// Full names of states.
    states: Known,
    guards: Known,
    callbacks: Known,
    behaviors: Known,
    /// The triggers of the host, or those of the rows so far.
    triggers: Known,
    /// The triggers that the file lists.
    listed: Known,
    /// Declared rows, with lists expanded, before sorting.
    rows: Vec<Row>,
}

impl<'a> Compiler<'a> {
    fn new(definition: &'a Definition, vocabulary: &'a Vocabulary<'a>) -> Self {
        let out = Table {
            name: definition.name.clone(),
            states: Vec::new(),
            by_rank: Vec::new(),
            levels: Vec::new(),
            initial: StateId(0),
            triggers: Vec::new(),
            guards: Vec::new(),
            callbacks: Vec::new(),
            behaviors: Vec::new(),
            rows: Vec::new(),
            index: Vec::new(),
            conditions: Vec::new(),
            calls: Vec::new(),
            common: Common::default(),
            during: super::set::SmallSet::default(),
            ignore_invalid: definition.ignore_invalid_triggers,
            row_lines: Vec::new(),
        };
        Self {
            definition,
            vocabulary,
            problems: Collector::default(),
            out,
            states: Known::default(),
            guards: Known::new(vocabulary.guards),
            callbacks: Known::new(vocabulary.callbacks),
            behaviors: Known::new(vocabulary.behaviors),
            triggers: Known::new(vocabulary.triggers),
            listed: Known::new(definition.triggers.iter().map(|name| &name.text)),
            rows: Vec::new(),
        }
    }

    fn check_host(&mut self) {
        let Vocabulary {
            guards, triggers, ..
        } = self.vocabulary;
        // Sets of guards are bit sets of this size; a larger host is a defect of the program,
        // and is reported with the file.
        for (what, count, most) in [
            ("guards", guards.len(), MAX_MEMBERS),
            ("triggers", triggers.len(), MAX_TRIGGERS),
        ] {
            if count > most {
                let message = format!("the host knows {count} {what}, at most {most} can be");
                self.problems.add(Location::default(), message);
            }
        }
    }

    fn state_id(&mut self, name: &Name) -> Option<StateId> {
        let found = self.states.look_up("state", name, &mut self.problems);
        found.map(StateId::of)
    }

    fn calls(&mut self, names: &[Name]) -> Span {
        let start = self.out.calls.len();
        for name in names {
            let found = self.callbacks.look_up("callback", name, &mut self.problems);
            self.out.calls.extend(found.map(CallbackId::of));
        }
        span(start, self.out.calls.len())
    }

    fn conditions(&mut self, holding: &[Name], unless: &[Name]) -> Span {
        let start = self.out.conditions.len();
        for (names, expected) in [(holding, true), (unless, false)] {
            for name in names {
                let found = self.guards.look_up("guard", name, &mut self.problems);
                let condition = found.map(|index| Condition {
                    guard: GuardId::of(index),
                    expected,
                });
                self.out.conditions.extend(condition);
            }
        }
        span(start, self.out.conditions.len())
    }

    /// A trigger that a row has.
    fn known_trigger(&mut self, name: &Name) -> Option<TriggerId> {
        let found = self.triggers.look_up("trigger", name, &mut self.problems);
        found.map(TriggerId::of)
    }

    /// The trigger of a row; it has to be in the lists of the host and of the file, if these
    /// exist.
    fn row_trigger(&mut self, name: &Name) -> Option<TriggerId> {
        if !self.definition.triggers.is_empty() {
            self.listed.look_up("trigger", name, &mut self.problems)?;
        }
        // A host without a list accepts every trigger; the rows then define them.
        if self.vocabulary.triggers.is_empty() {
            return self.new_trigger(name);
        }
        self.known_trigger(name)
    }

    /// The trigger with this name, added if necessary.
    fn new_trigger(&mut self, name: &Name) -> Option<TriggerId> {
        if name.text.is_empty() {
            self.problems.add(name.place, "a trigger needs a name");
            return None;
        }
        if let Some(known) = self.triggers.find(&name.text) {
            return Some(TriggerId::of(known));
        }
        if self.triggers.names().len() >= MAX_TRIGGERS {
            let message = format!("more than {MAX_TRIGGERS} triggers");
            self.problems.add(name.place, message);
            return None;
        }
        Some(TriggerId::of(self.triggers.push(&name.text)))
    }
}

fn span(start: usize, end: usize) -> Span {
    let cut = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
    Span {
        start: cut(start),
        end: cut(end),
    }
}
