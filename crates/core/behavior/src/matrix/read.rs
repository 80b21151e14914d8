//! A matrix's definition from TOML or JSON.

use super::definition::{CellDef, Definition, DuringDef, StateDef};
use super::ids::{MAX_EVENTS, MAX_HANDLERS, Vocabulary};
use super::table::Table;
use crate::descriptor::json::{Data, Entry, Value};
use crate::machine::problem::Collector;
use crate::machine::read::fields::{Fields, name_of};
use crate::machine::read::machine::run_name;
use crate::machine::read::text;
use crate::machine::{Final, MAX_MEMBERS, Name, Problems};

const FILE: &[&str] = &[
    "version",
    "name",
    "doc",
    "precedence",
    "idle",
    "states",
    "initial",
    "cells",
    "every",
    // Used by the host, see `crate::inline` and `crate::numbers`.
    "events",
    "handlers",
    "numbers",
    "precision",
];
const STATE: &[&str] = &["name", "final", "during"];
const DURING: &[&str] = &["run", "steps", "success", "failure"];
const CELL: &[&str] = &["handler", "goto"];

impl Definition {
    /// Reads a definition: JSON if the name of the file ends with `.json`, TOML
    /// otherwise. Names are checked by [`Definition::compile`].
    ///
    /// # Errors
    /// Every mistake in its syntax and keys, at once.
    pub fn read(file: &str, text: &str) -> Result<Self, Problems> {
        let (definition, problems) = read_part(file, text)?;
        problems.finish(file, definition)
    }

    /// Reads and compiles.
    ///
    /// # Errors
    /// Every mistake at once, in the order of the text.
    pub fn load(file: &str, text: &str, vocabulary: &Vocabulary<'_>) -> Result<Table, Problems> {
        let (definition, problems) = read_part(file, text)?;
        Problems::join(file, problems.0, definition.compile(vocabulary))
    }
}

fn read_part(file: &str, text: &str) -> Result<(Definition, Collector), Problems> {
    let value = text::parse(file, text)?;
    let mut problems = Collector::default();
    match definition(file, &value, &mut problems) {
        Some(definition) => {
            // Sizes are checked before the caller compiles, without the names of a host.
            definition.check_sizes(&Vocabulary::default())?;
            Ok((definition, problems))
        }
        None => Err(Problems::new(file, problems.0)),
    }
}

fn definition(file: &str, value: &Value, problems: &mut Collector) -> Option<Definition> {
    let fields = Fields::open(value, "a matrix", FILE, problems)?;
    let limits = [
        ("cells", MAX_MEMBERS),
        ("every", MAX_EVENTS),
        ("events", MAX_EVENTS),
        ("handlers", MAX_HANDLERS),
    ];
    // Tables are refused by their length, before each of their entries is read.
    if !fields.fit(&limits, problems) {
        return None;
    }
    fields.check_version(problems);
    let states = fields.list("states", problems).iter();
    let states = states.filter_map(|value| state(value, problems)).collect();
    let mut cells = Vec::new();
    for entry in fields.table("cells", problems) {
        let state = Name {
            text: entry.key.clone(),
            place: entry.place.into(),
        };
        row(Some(&state), entry, &mut cells, problems);
    }
    for entry in fields.table("every", problems) {
        cells.extend(cell(None, entry, problems));
    }
    Some(Definition {
        file: file.to_owned(),
        name: fields
            .required("name", problems)
            .map(|name| name.text)
            .unwrap_or_default(),
        precedence: fields.names("precedence", problems),
        idle: fields.name("idle", problems),
        states,
        initial: fields.required("initial", problems),
        cells,
    })
}

fn state(value: &Value, problems: &mut Collector) -> Option<StateDef> {
    if value.as_text().is_some() {
        return Some(StateDef {
            name: name_of(value, problems)?,
            end: Final::No,
            during: None,
        });
    }
    let fields = Fields::open(value, "a state", STATE, problems)?;
    let name = fields.required("name", problems)?;
    let during = fields
        .get("during")
        .and_then(|value| during(value, &name.text, problems));
    Some(StateDef {
        end: if fields.flag("final", false, problems) {
            Final::Success
        } else {
            Final::No
        },
        during,
        name,
    })
}

fn during(value: &Value, state: &str, problems: &mut Collector) -> Option<DuringDef> {
    let fields = Fields::open(value, "'during'", DURING, problems)?;
    Some(DuringDef {
        run: run_name(&fields, state, problems)?,
        success: fields.name("success", problems),
        failure: fields.name("failure", problems),
    })
}

fn row(state: Option<&Name>, entry: &Entry, out: &mut Vec<CellDef>, problems: &mut Collector) {
    if let Some(cells) = entry.value.as_object() {
        out.extend(cells.iter().filter_map(|it| cell(state, it, problems)));
        return;
    }
    let message = format!(
        "the cells of a state are a table of EVENT = handler, not {}",
        entry.value.describe()
    );
    problems.add(entry.value.place.into(), message);
}

fn cell(state: Option<&Name>, entry: &Entry, problems: &mut Collector) -> Option<CellDef> {
    let event = Name {
        text: entry.key.clone(),
        place: entry.place.into(),
    };
    let state = state.cloned();
    let value = &entry.value;
    if let Data::Text(_) = value.data {
        return Some(CellDef {
            state,
            event,
            handler: name_of(value, problems)?,
            goto: Vec::new(),
        });
    }
    let fields = Fields::open(value, "a cell", CELL, problems)?;
    Some(CellDef {
        state,
        event,
        handler: fields.required("handler", problems)?,
        goto: fields.names("goto", problems),
    })
}
