//! From a definition to flat arrays, refusing every name without a meaning.

use super::definition::{CellDef, Definition};
use super::ids::{EventId, HandlerId, MAX_EVENTS, Vocabulary};
use super::table::{During, Filled, State, Table};
use crate::descriptor::json::shortened;
use crate::machine::problem::{Collector, Location};
use crate::machine::record::name_hash;
use crate::machine::{BehaviorId, Final, MAX_MEMBERS, Name, Problems, StateId};
use crate::suggest;

impl Definition {
    /// Compiles it for a host that knows `vocabulary`.
    ///
    /// # Errors
    /// Everything that is wrong at once: names without a meaning, names and
    /// cells given twice, events without precedence, limits.
    pub fn compile(&self, vocabulary: &Vocabulary<'_>) -> Result<Table, Problems> {
        let mut compiler = Compiler {
            definition: self,
            vocabulary,
            problems: Collector::default(),
        };
        let table = compiler.table();
        compiler.problems.finish(&self.file, table)
    }
}

struct Compiler<'a> {
    definition: &'a Definition,
    vocabulary: &'a Vocabulary<'a>,
    problems: Collector,
}

fn texts(names: &[Name]) -> Vec<&str> {
    names.iter().map(|name| name.text.as_str()).collect()
}

fn owned(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

impl Compiler<'_> {
    fn table(&mut self) -> Table {
        let (definition, vocabulary) = (self.definition, self.vocabulary);
        let events = self.names(
            "event",
            &definition.precedence,
            vocabulary.events,
            MAX_EVENTS,
        );
        let state_names: Vec<Name> = definition.states.iter().map(|it| it.name.clone()).collect();
        let states = self.names("state", &state_names, vocabulary.states, MAX_MEMBERS);
        let mut table = Table {
            name: definition.name.clone(),
            states: states
                .iter()
                .map(|name| self.state(name, &events))
                .collect(),
            initial: StateId(0),
            handlers: owned(vocabulary.handlers),
            behaviors: owned(vocabulary.behaviors),
            order: Vec::new(),
            idle: None,
            cells: vec![None; states.len() * events.len()],
            events: owned(&events),
        };
        let order = definition.precedence.iter();
        table.order = order
            .filter_map(|it| position(&events, &it.text).map(event))
            .collect();
        let idle = definition.idle.as_ref();
        table.idle = idle
            .and_then(|it| self.look_up("event", it, &events))
            .map(event);
        if let Some(initial) = definition.initial.as_ref().or(state_names.first()) {
            let found = self.look_up("state", initial, &states);
            table.initial = found.map_or(StateId(0), StateId::of);
        }
        self.fill(&mut table, &states, &events);
        table
    }

    /// The names of a kind in the order of their ids. Both lists must have the
    /// same ones, if the host names any.
    fn names<'n>(
        &mut self,
        what: &str,
        written: &'n [Name],
        known: &'n [&'n str],
        limit: usize,
    ) -> Vec<&'n str> {
        let place = written.first().map(|name| name.place).unwrap_or_default();
        if written.is_empty() {
            self.problems
                .add(place, format!("the matrix has no {what}s"));
        }
        if written.len().max(known.len()) > limit {
            self.problems
                .add(place, format!("at most {limit} {what}s can be"));
            return Vec::new();
        }
        let all = texts(written);
        for (at, name) in written.iter().enumerate() {
            let earlier = all.get(..at).unwrap_or_default();
            if earlier.contains(&name.text.as_str()) {
                let message = format!("{what} '{}' is there twice", shortened(&name.text));
                self.problems.add(name.place, message);
            }
            if !known.is_empty() {
                self.look_up(what, name, known);
            }
        }
        for name in known.iter().filter(|name| !all.contains(*name)) {
            let list = if what == "event" {
                "the precedence list"
            } else {
                "the states"
            };
            self.problems.add(
                place,
                format!("{what} '{name}' is missing in {list}; add it"),
            );
        }
        if known.is_empty() {
            all
        } else {
            known.to_vec()
        }
    }

    fn look_up(&mut self, what: &str, name: &Name, known: &[&str]) -> Option<usize> {
        let found = position(known, &name.text);
        if found.is_none() {
            let text = shortened(&name.text);
            let advice = suggest::advice(&text, known);
            self.problems
                .add(name.place, format!("unknown {what} '{text}'; {advice}"));
        }
        found
    }

    fn state(&mut self, name: &str, events: &[&str]) -> State {
        let def = self
            .definition
            .states
            .iter()
            .find(|it| it.name.text == name);
        let during = def.and_then(|def| def.during.as_ref());
        State {
            name: name.to_owned(),
            hash: name_hash(name),
            end: def.map_or(Final::No, |def| def.end),
            during: during.and_then(|during| {
                let known = self.vocabulary.behaviors;
                let run = self.look_up("sub-behaviour", &during.run, known);
                let mut result = |name: &Option<Name>| {
                    let name = name.as_ref()?;
                    self.look_up("event", name, events).map(event)
                };
                let (success, failure) = (result(&during.success), result(&during.failure));
                Some(During {
                    run: BehaviorId::of(run?),
                    success,
                    failure,
                })
            }),
        }
    }

    /// Cells of single states first; those for every state fill the remaining ones.
    fn fill(&mut self, table: &mut Table, states: &[&str], events: &[&str]) {
        let cells = self.definition.cells.iter();
        let (single, every): (Vec<_>, Vec<_>) = cells.partition(|cell| cell.state.is_some());
        for cell in single {
            let state = cell.state.as_ref();
            let state = state.and_then(|name| self.look_up("state", name, states));
            let Some((at, filled)) = self.filled(cell, states, events) else {
                continue;
            };
            let Some(slot) = state.and_then(|state| table.cells.get_mut(state * events.len() + at))
            else {
                continue;
            };
            if slot.is_some() {
                self.twice(cell.event.place, cell);
            }
            *slot = Some(filled);
        }
        let mut seen = vec![false; events.len()];
        for cell in every {
            let Some((at, filled)) = self.filled(cell, states, events) else {
                continue;
            };
            if seen
                .get_mut(at)
                .is_some_and(|seen| std::mem::replace(seen, true))
            {
                self.twice(cell.event.place, cell);
            }
            for row in table.cells.chunks_mut(events.len().max(1)) {
                if let Some(slot @ None) = row.get_mut(at) {
                    *slot = Some(filled.clone());
                }
            }
        }
    }

    fn twice(&mut self, place: Location, cell: &CellDef) {
        let state = cell.state.as_ref().map_or("every state", |name| &name.text);
        let message = format!(
            "the cell of '{}' in {state} is filled in twice",
            cell.event.text
        );
        self.problems.add(place, message);
    }

    fn filled(
        &mut self,
        cell: &CellDef,
        states: &[&str],
        events: &[&str],
    ) -> Option<(usize, Filled)> {
        let at = self.look_up("event", &cell.event, events);
        let handler = self.look_up("handler", &cell.handler, self.vocabulary.handlers);
        let goto = cell
            .goto
            .iter()
            .filter_map(|name| self.look_up("state", name, states));
        let goto = goto.map(StateId::of).collect();
        let handler = HandlerId(u16::try_from(handler?).ok()?);
        Some((at?, Filled { handler, goto }))
    }
}

fn position(known: &[&str], name: &str) -> Option<usize> {
    known.iter().position(|it| *it == name)
}

fn event(at: usize) -> EventId {
    EventId(u16::try_from(at).unwrap_or(u16::MAX))
}
