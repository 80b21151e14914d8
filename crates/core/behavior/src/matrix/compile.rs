//! Compiles a definition into flat arrays; a name without a meaning is an error.

use super::definition::{CellDef, Definition};
use super::ids::{EventId, HandlerId, MAX_EVENTS, MAX_HANDLERS, Vocabulary};
use super::table::{During, Filled, State, Table};
use crate::descriptor::json::shortened;
use crate::known::Known;
use crate::machine::problem::{Collector, Location, Problem};
use crate::machine::record::name_hash;
use crate::machine::set::SmallSet;
use crate::machine::{BehaviorId, Final, MAX_MEMBERS, Name, Problems, StateId};

impl Definition {
    /// Compiles it for a host that knows `vocabulary`.
    ///
    /// # Errors
    /// All mistakes at once: names without a meaning, duplicate names and
    /// cells, events without precedence, limits.
    pub fn compile(&self, vocabulary: &Vocabulary<'_>) -> Result<Table, Problems> {
        // Sizes first: the table has a cell for each state and event.
        self.check_sizes(vocabulary)?;
        let mut compiler = Compiler {
            definition: self,
            handlers: Known::new(vocabulary.handlers),
            behaviors: Known::new(vocabulary.behaviors),
            problems: Collector::default(),
        };
        let table = compiler.table(vocabulary);
        compiler.problems.finish(&self.file, table)
    }

    /// Refuses a matrix that is too large, without any further check.
    pub(super) fn check_sizes(&self, vocabulary: &Vocabulary<'_>) -> Result<(), Problems> {
        let (events, states) = (&self.precedence, &self.states);
        let events = (events.len(), events.get(MAX_EVENTS).map(|name| name.place));
        let states = (
            states.len(),
            states.get(MAX_MEMBERS).map(|it| it.name.place),
        );
        // The names of the host are limited as well: events are bits of a set.
        let host = |names: &[&str]| (names.len(), Some(Location::default()));
        let sizes = [
            ("events", events, MAX_EVENTS),
            ("states", states, MAX_MEMBERS),
            ("events", host(vocabulary.events), MAX_EVENTS),
            ("states", host(vocabulary.states), MAX_MEMBERS),
            ("handlers", host(vocabulary.handlers), MAX_HANDLERS),
        ];
        let list: Vec<Problem> = sizes
            .into_iter()
            .filter(|(_, (count, _), most)| count > most)
            .map(|(what, (count, place), most)| Problem {
                place: place.unwrap_or_default(),
                message: format!("{count} {what}; at most {most} can be"),
            })
            .collect();
        if list.is_empty() {
            return Ok(());
        }
        Err(Problems::new(&self.file, list))
    }
}

struct Compiler<'a> {
    definition: &'a Definition,
    handlers: Known,
    behaviors: Known,
    problems: Collector,
}

impl Compiler<'_> {
    fn table(&mut self, vocabulary: &Vocabulary<'_>) -> Table {
        let definition = self.definition;
        let events = self.names("event", &definition.precedence, vocabulary.events);
        let state_names: Vec<Name> = definition.states.iter().map(|it| it.name.clone()).collect();
        let states = self.names("state", &state_names, vocabulary.states);
        let (handlers, behaviors) = (self.handlers.names(), self.behaviors.names());
        let mut table = Table {
            name: definition.name.clone(),
            initial: StateId(0),
            handlers: handlers.to_vec(),
            behaviors: behaviors.to_vec(),
            order: Vec::new(),
            idle: None,
            cells: vec![None; states.names().len() * events.names().len()],
            events: events.names().to_vec(),
            states: states
                .names()
                .iter()
                .map(|name| self.state(name, &events))
                .collect(),
        };
        let order = definition.precedence.iter();
        table.order = order
            .filter_map(|it| events.find(&it.text).map(event))
            .collect();
        let idle = definition.idle.as_ref();
        table.idle = idle
            .and_then(|it| events.look_up("event", it, &mut self.problems))
            .map(event);
        // The first state is the initial one where the file does not name one.
        if let Some(initial) = definition.initial.as_ref().or(state_names.first()) {
            let found = states.look_up("state", initial, &mut self.problems);
            table.initial = found.map_or(StateId(0), StateId::of);
        }
        self.fill(&mut table, &states, &events);
        table
    }

    /// The names of a kind in the order of their ids. If the host has a list, both lists must
    /// have the same names.
    fn names(&mut self, what: &str, written: &[Name], host: &[&str]) -> Known {
        let place = written.first().map(|name| name.place).unwrap_or_default();
        if written.is_empty() {
            self.problems
                .add(place, format!("the matrix has no {what}s"));
        }
        let all = Known::new(written.iter().map(|name| &name.text));
        let known = Known::new(host);
        for (at, name) in written.iter().enumerate() {
            // Ids are positions, so a second one of the same name would have no id.
            if all.find(&name.text) != Some(at) {
                let message = format!("{what} '{}' is defined twice", shortened(&name.text));
                self.problems.add(name.place, message);
            }
            if !host.is_empty() {
                known.look_up(what, name, &mut self.problems);
            }
        }
        // An event without precedence could never be handled.
        for name in host.iter().filter(|name| all.find(name).is_none()) {
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
        // Ids of the host win: its code compares with them.
        if host.is_empty() { all } else { known }
    }

    fn state(&mut self, name: &str, events: &Known) -> State {
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
                let problems = &mut self.problems;
                let run = self
                    .behaviors
                    .look_up("sub-behaviour", &during.run, problems);
                let mut result = |name: &Option<Name>| {
                    let name = name.as_ref()?;
                    events.look_up("event", name, problems).map(event)
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

    /// Fills cells of single states first; those for every state fill the remaining ones.
    fn fill(&mut self, table: &mut Table, states: &Known, events: &Known) {
        let width = events.names().len();
        let cells = self.definition.cells.iter();
        let (single, every): (Vec<_>, Vec<_>) = cells.partition(|cell| cell.state.is_some());
        for cell in single {
            let state = cell.state.as_ref();
            let state = state.and_then(|name| states.look_up("state", name, &mut self.problems));
            let Some((at, filled)) = self.filled(cell, states, events) else {
                continue;
            };
            let Some(slot) = state.and_then(|state| table.cells.get_mut(state * width + at)) else {
                continue;
            };
            if slot.is_some() {
                self.twice(cell.event.place, cell);
            }
            *slot = Some(filled);
        }
        // A cell for every state is checked once, not once for each state that it fills.
        let mut seen = vec![false; width];
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
            for row in table.cells.chunks_mut(width.max(1)) {
                // A cell of a single state is more specific, and stays.
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
        states: &Known,
        events: &Known,
    ) -> Option<(usize, Filled)> {
        let problems = &mut self.problems;
        let at = events.look_up("event", &cell.event, problems);
        let handler = self.handlers.look_up("handler", &cell.handler, problems);
        let mut goto = Vec::new();
        // A duplicate counts once: cells for every state are copied into each state.
        let mut seen = SmallSet::default();
        for name in &cell.goto {
            let found = states.look_up("state", name, problems);
            if let Some(state) = found.filter(|state| !seen.contains(*state)) {
                seen.insert(state);
                goto.push(StateId::of(state));
            }
        }
        let handler = HandlerId(u16::try_from(handler?).ok()?);
        Some((at?, Filled { handler, goto }))
    }
}

fn event(at: usize) -> EventId {
    EventId(u16::try_from(at).unwrap_or(u16::MAX))
}
