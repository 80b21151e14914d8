//! Rows: lists and wildcards are expanded, then rows are sorted by trigger and source.

use super::{Compiler, MAX_ROWS, span};
use crate::machine::definition::{DestDef, Name, OrderedDef, RowDef, SourceDef};
use crate::machine::ids::{RowId, StateId, TriggerId};
use crate::machine::problem::Location;
use crate::machine::table::{Common, Row, Span};

impl Compiler<'_> {
    pub(super) fn add_rows(&mut self) {
        let definition = self.definition;
        for row in &definition.rows {
            self.add_row(row);
            // A list of sources multiplies the rows of a file: expansion stops at the limit.
            if self.rows.len() > MAX_ROWS {
                return;
            }
        }
        // Chains and automatic rows have ids after those of the written rows, so messages and
        // traces number the rows as the file does.
        for chain in &definition.ordered {
            self.add_chain(chain);
        }
        if definition.auto_transitions {
            self.add_automatic();
        }
        self.out.common = Common {
            prepare_event: self.calls(&definition.prepare_event),
            before_state_change: self.calls(&definition.before_state_change),
            after_state_change: self.calls(&definition.after_state_change),
            finalize_event: self.calls(&definition.finalize_event),
            on_final: self.calls(&definition.on_final),
        };
        // Triggers of sub-behaviours can name those of chains and automatic rows.
        self.add_results();
        self.sort();
    }

    fn declare(&mut self, place: Location) -> RowId {
        self.out.row_lines.push(place.line);
        RowId::of(self.out.row_lines.len() - 1)
    }

    fn add_row(&mut self, def: &RowDef) {
        let id = self.declare(def.place);
        // Every part is looked up even if one fails, so that a file reports all its mistakes.
        let trigger = self.row_trigger(&def.trigger);
        let sources = self.sources(&def.source, &def.dest);
        let dest = match &def.dest {
            DestDef::To(name) => self.state_id(name),
            DestDef::Same | DestDef::Internal => None,
        };
        let row = Row {
            id,
            trigger: trigger.unwrap_or(TriggerId(0)),
            source: StateId(0),
            dest,
            conditions: self.conditions(&def.conditions, &def.unless),
            prepare: self.calls(&def.prepare),
            before: self.calls(&def.before),
            after: self.calls(&def.after),
        };
        let Some(_) = trigger else { return };
        for source in sources {
            let dest = match def.dest {
                DestDef::Same => Some(source),
                _ => dest,
            };
            self.push(
                def.place,
                Row {
                    source,
                    dest,
                    ..row.clone()
                },
            );
        }
    }

    fn sources(&mut self, source: &SourceDef, dest: &DestDef) -> Vec<StateId> {
        match source {
            SourceDef::Any(_) => {
                // "Each state into itself" includes the inner states.
                let inner = *dest == DestDef::Same;
                let all = self.out.states.iter().enumerate();
                // For other rows the outermost level is enough: a state inside uses the rows of
                // its parents.
                all.filter(|(_, state)| inner || state.parent.is_none())
                    .map(|(at, _)| StateId::of(at))
                    .collect()
            }
            SourceDef::These(names) => names
                .iter()
                .filter_map(|name| self.state_id(name))
                .collect(),
        }
    }

    fn push(&mut self, place: Location, row: Row) {
        // Reported once, at the row that exceeds the limit.
        match self.rows.len() {
            MAX_ROWS => {
                let message =
                    format!("more than {MAX_ROWS} rows once lists and '*' are written out");
                self.problems.add(place, message);
            }
            len if len > MAX_ROWS => return,
            _ => {}
        }
        self.rows.push(row);
    }

    fn add_chain(&mut self, def: &OrderedDef) {
        let Some(trigger) = self.row_trigger(&def.trigger) else {
            return;
        };
        let mut states: Vec<StateId> = if def.states.is_empty() {
            self.sources(&SourceDef::Any(def.place), &DestDef::Internal)
        } else {
            def.states
                .iter()
                .filter_map(|name| self.state_id(name))
                .collect()
        };
        if states.len() < 2 {
            let message = "an ordered chain needs at least two states";
            self.problems.add(def.place, message);
            return;
        }
        // As in `transitions`, the chain starts with the initial state.
        if let Some(at) = states.iter().position(|state| *state == self.out.initial) {
            states.rotate_left(at);
        }
        let conditions = self.conditions(&def.conditions, &def.unless);
        // The row from the last state back to the first one.
        let last = states.first().copied().filter(|_| def.cyclic);
        let next = states.iter().copied().skip(1).chain(last);
        for (source, dest) in states.iter().copied().zip(next) {
            let id = self.declare(def.place);
            self.push(def.place, plain(id, trigger, source, dest, conditions));
        }
    }

    fn add_automatic(&mut self) {
        let outer = self.sources(&SourceDef::Any(Location::default()), &DestDef::Internal);
        for at in 0..self.states.names().len() {
            let Some(full) = self.states.names().get(at) else {
                continue;
            };
            let name = Name::from(format!("to_{full}").as_str());
            // A name that a written row uses already keeps its trigger, and gets further rows.
            let Some(trigger) = self.new_trigger(&name) else {
                continue;
            };
            let id = self.declare(Location::default());
            for source in &outer {
                let row = plain(id, trigger, *source, StateId::of(at), Span::default());
                self.push(Location::default(), row);
            }
        }
    }

    /// Sorts rows so that those of one trigger and source are adjacent, in the order of their
    /// declaration.
    fn sort(&mut self) {
        let mut rows = std::mem::take(&mut self.rows);
        let count = self.out.states.len();
        let rank = |row: &Row| self.out.get(row.source).map_or(0, |state| state.rank);
        let cell = |row: &Row| row.trigger.index() * count + rank(row);
        // A stable sort: the order of declaration is the precedence of the rows.
        rows.sort_by_key(cell);
        // One span per trigger and state: the rows of a state are found without a search.
        let mut index = vec![Span::default(); self.triggers.names().len() * count];
        let mut start = 0;
        for group in rows.chunk_by(|a, b| cell(a) == cell(b)) {
            let end = start + group.len();
            if let Some(entry) = group.first().and_then(|row| index.get_mut(cell(row))) {
                *entry = span(start, end);
            }
            start = end;
        }
        self.out.rows = rows;
        self.out.index = index;
    }
}

fn plain(id: RowId, trigger: TriggerId, source: StateId, dest: StateId, conditions: Span) -> Row {
    Row {
        id,
        trigger,
        source,
        dest: Some(dest),
        conditions,
        prepare: Span::default(),
        before: Span::default(),
        after: Span::default(),
    }
}
