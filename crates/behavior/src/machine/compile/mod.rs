//! From a definition to flat arrays, refusing every name without a meaning.

mod rows;
mod states;

use super::definition::{Definition, Name};
use super::ids::{CallbackId, GuardId, StateId, TriggerId, Vocabulary};
use super::problem::{Collector, Location, Problems};
use super::set::MAX_MEMBERS;
use super::table::{Common, Condition, Row, Span, Table};
use crate::descriptor::json::shortened;
use crate::suggest;

/// Most rows after lists and wildcards are written out.
const MAX_ROWS: usize = 65_000;
/// Most triggers.
const MAX_TRIGGERS: usize = 4_096;

impl Definition {
    /// Compiles it for a host that knows `vocabulary`.
    ///
    /// # Errors
    /// Everything that is wrong at once: names of states, guards, callbacks,
    /// sub-behaviours and triggers without a meaning, duplicates, limits.
    pub fn compile(&self, vocabulary: &Vocabulary<'_>) -> Result<Table, Problems> {
        let mut compiler = Compiler::new(self, vocabulary);
        compiler.check_sizes();
        compiler.add_states();
        if compiler.problems.0.is_empty() || !compiler.states.is_empty() {
            compiler.add_rows();
        }
        let Compiler {
            problems, mut out, ..
        } = compiler;
        out.row_lines.shrink_to_fit();
        problems.finish(&self.file, out)
    }
}

/// What is known while compiling.
struct Compiler<'a> {
    definition: &'a Definition,
    vocabulary: &'a Vocabulary<'a>,
    problems: Collector,
    out: Table,
    /// Full names of states, for advice.
    states: Vec<String>,
    /// Declared rows, lists written out, before sorting.
    rows: Vec<Row>,
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

impl<'a> Compiler<'a> {
    fn new(definition: &'a Definition, vocabulary: &'a Vocabulary<'a>) -> Self {
        let out = Table {
            name: definition.name.clone(),
            states: Vec::new(),
            by_rank: Vec::new(),
            levels: Vec::new(),
            initial: StateId(0),
            triggers: owned(vocabulary.triggers),
            guards: owned(vocabulary.guards),
            callbacks: owned(vocabulary.callbacks),
            behaviors: owned(vocabulary.behaviors),
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
            states: Vec::new(),
            rows: Vec::new(),
        }
    }

    fn check_sizes(&mut self) {
        let guards = self.vocabulary.guards.len();
        if guards > MAX_MEMBERS {
            let message = format!("the host knows {guards} guards, at most {MAX_MEMBERS} can be");
            self.problems.add(Location::default(), message);
        }
    }

    /// Location of `name` among `known`; otherwise a problem.
    fn look_up<S: AsRef<str>>(&mut self, what: &str, name: &Name, known: &[S]) -> Option<usize> {
        let found = known.iter().position(|it| it.as_ref() == name.text);
        if found.is_none() {
            let known: Vec<&str> = known.iter().map(AsRef::as_ref).collect();
            let text = shortened(&name.text);
            let advice = suggest::advice(&text, &known);
            let message = format!("unknown {what} '{text}'; {advice}");
            self.problems.add(name.place, message);
        }
        found
    }

    fn state_id(&mut self, name: &Name) -> Option<StateId> {
        let states = std::mem::take(&mut self.states);
        let found = self.look_up("state", name, &states);
        self.states = states;
        found.map(StateId::of)
    }

    fn calls(&mut self, names: &[Name]) -> Span {
        let start = self.out.calls.len();
        for name in names {
            let known = self.vocabulary.callbacks;
            if let Some(index) = self.look_up("callback", name, known) {
                self.out.calls.push(CallbackId::of(index));
            }
        }
        span(start, self.out.calls.len())
    }

    fn conditions(&mut self, holding: &[Name], unless: &[Name]) -> Span {
        let start = self.out.conditions.len();
        for (names, expected) in [(holding, true), (unless, false)] {
            for name in names {
                let known = self.vocabulary.guards;
                if let Some(index) = self.look_up("guard", name, known) {
                    let guard = GuardId::of(index);
                    self.out.conditions.push(Condition { guard, expected });
                }
            }
        }
        span(start, self.out.conditions.len())
    }

    /// A trigger that some row has.
    fn known_trigger(&mut self, name: &Name) -> Option<TriggerId> {
        let triggers = std::mem::take(&mut self.out.triggers);
        let found = self.look_up("trigger", name, &triggers);
        self.out.triggers = triggers;
        found.map(TriggerId::of)
    }

    /// The trigger of a row: known to the host and to the file, where these say.
    fn row_trigger(&mut self, name: &Name) -> Option<TriggerId> {
        let definition = self.definition;
        if !definition.triggers.is_empty() {
            let known: Vec<&str> = definition
                .triggers
                .iter()
                .map(|it| it.text.as_str())
                .collect();
            self.look_up("trigger", name, &known)?;
        }
        let known = self.vocabulary.triggers;
        if known.is_empty() {
            return self.new_trigger(name);
        }
        self.look_up("trigger", name, known).map(TriggerId::of)
    }

    /// The trigger of this name, added if need be.
    fn new_trigger(&mut self, name: &Name) -> Option<TriggerId> {
        if name.text.is_empty() {
            self.problems.add(name.place, "a trigger needs a name");
            return None;
        }
        if let Some(known) = self.out.trigger(&name.text) {
            return Some(known);
        }
        if self.out.triggers.len() >= MAX_TRIGGERS {
            let message = format!("more than {MAX_TRIGGERS} triggers");
            self.problems.add(name.place, message);
            return None;
        }
        self.out.triggers.push(name.text.clone());
        Some(TriggerId::of(self.out.triggers.len() - 1))
    }
}

fn span(start: usize, end: usize) -> Span {
    let cut = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
    Span {
        start: cut(start),
        end: cut(end),
    }
}
