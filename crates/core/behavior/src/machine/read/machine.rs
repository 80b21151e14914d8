//! A machine's definition from TOML or JSON.

use super::fields::{Fields, name_of};
use super::text;
use crate::descriptor::json::{Data, Value};
use crate::machine::compile::MAX_TRIGGERS;
use crate::machine::definition::{
    Definition, DestDef, DuringDef, Final, Name, OrderedDef, RowDef, SourceDef, StateDef,
};
use crate::machine::ids::Vocabulary;
use crate::machine::problem::{Collector, Problems};
use crate::machine::set::MAX_MEMBERS;
use crate::machine::table::Table;

/// Largest depth of nested states that is read.
// Bounds the recursion here. Larger than the limit of the compiler, which reports the depth
// with the names of the states.
const MAX_DEPTH: usize = 32;
const FILE: &[&str] = &[
    "version",
    "name",
    "doc",
    "states",
    "initial",
    "triggers",
    "rows",
    "ordered",
    "prepare_event",
    "before_state_change",
    "after_state_change",
    "finalize_event",
    "on_final",
    "auto_transitions",
    "ignore_invalid_triggers",
    // Used by the host, see `crate::inline` and `crate::numbers`.
    "conditions",
    "events",
    "numbers",
    "precision",
];
const STATE: &[&str] = &[
    "name", "enter", "exit", "initial", "children", "parallel", "final", "during",
];
const ROW: &[&str] = &[
    "trigger",
    "source",
    "dest",
    "internal",
    "conditions",
    "unless",
    "prepare",
    "before",
    "after",
];
const ORDERED: &[&str] = &["trigger", "states", "loop", "conditions", "unless"];
const DURING: &[&str] = &["run", "steps", "success", "failure"];

impl Definition {
    /// Reads a definition: JSON if the name of the file ends with `.json`, TOML
    /// otherwise. Names are checked by [`Definition::compile`].
    ///
    /// # Errors
    /// Every mistake in its syntax and keys, at once.
    pub fn read(file: &str, text: &str) -> Result<Self, Problems> {
        let (definition, problems) = Self::read_part(file, text)?;
        problems.finish(file, definition)
    }

    /// Reads and compiles.
    ///
    /// # Errors
    /// Every mistake at once, in the order of the text.
    pub fn load(file: &str, text: &str, vocabulary: &Vocabulary<'_>) -> Result<Table, Problems> {
        let (definition, problems) = Self::read_part(file, text)?;
        Problems::join(file, problems.0, definition.compile(vocabulary))
    }

    fn read_part(file: &str, text: &str) -> Result<(Self, Collector), Problems> {
        let value = text::parse(file, text)?;
        let mut problems = Collector::default();
        let definition = definition(file, &value, &mut problems);
        match definition {
            Some(definition) => {
                // Before the caller compiles: a file that is too large is refused by its sizes
                // alone.
                definition.check_sizes()?;
                Ok((definition, problems))
            }
            None => Err(Problems::new(file, problems.0)),
        }
    }
}

fn definition(file: &str, value: &Value, problems: &mut Collector) -> Option<Definition> {
    let fields = Fields::open(value, "a machine", FILE, problems)?;
    // The tables of the host are checked here, as their entries are read by others without
    // limit.
    if !fields.fit(
        &[("conditions", MAX_MEMBERS), ("events", MAX_TRIGGERS)],
        problems,
    ) {
        return None;
    }
    fields.check_version(problems);
    let states = states(fields.list("states", problems), "", 0, problems);
    let rows = fields.list("rows", problems).iter();
    let rows = rows.filter_map(|value| row(value, problems)).collect();
    let chains = fields.list("ordered", problems).iter();
    let ordered = chains
        .filter_map(|value| ordered(value, problems))
        .collect();
    Some(Definition {
        file: file.to_owned(),
        name: fields
            .required("name", problems)
            .map(|name| name.text)
            .unwrap_or_default(),
        initial: fields.required("initial", problems),
        states,
        triggers: fields.names("triggers", problems),
        rows,
        ordered,
        prepare_event: fields.names("prepare_event", problems),
        before_state_change: fields.names("before_state_change", problems),
        after_state_change: fields.names("after_state_change", problems),
        finalize_event: fields.names("finalize_event", problems),
        on_final: fields.names("on_final", problems),
        auto_transitions: fields.flag("auto_transitions", false, problems),
        ignore_invalid_triggers: fields.flag("ignore_invalid_triggers", false, problems),
    })
}

fn states(values: &[Value], parent: &str, depth: usize, problems: &mut Collector) -> Vec<StateDef> {
    let read = values.iter().filter_map(|value| match &value.data {
        Data::Text(_) => {
            let name = name_of(value, problems)?;
            Some(StateDef {
                name,
                ..StateDef::new("")
            })
        }
        _ => state(value, parent, depth, problems),
    });
    read.collect()
}

fn state(value: &Value, parent: &str, depth: usize, problems: &mut Collector) -> Option<StateDef> {
    let fields = Fields::open(value, "a state", STATE, problems)?;
    let name = fields.required("name", problems)?;
    let children = fields.list("children", problems);
    if depth >= MAX_DEPTH && !children.is_empty() {
        let message = format!("states more than {MAX_DEPTH} deep in one another");
        problems.add(name.place, message);
        return None;
    }
    // Steps that are written in a state are named by its full name, so it is built here.
    let full = match parent {
        "" => name.text.clone(),
        parent => format!("{parent}.{}", name.text),
    };
    Some(StateDef {
        enter: fields.names("enter", problems),
        exit: fields.names("exit", problems),
        initial: fields.name("initial", problems),
        children: states(children, &full, depth + 1, problems),
        parallel: fields.flag("parallel", false, problems),
        end: end(&fields, problems),
        during: during(&fields, &full, problems),
        name,
    })
}

fn end(fields: &Fields<'_>, problems: &mut Collector) -> Final {
    let Some(value) = fields.get("final") else {
        return Final::No;
    };
    match &value.data {
        Data::Bool(false) => Final::No,
        Data::Bool(true) => Final::Success,
        Data::Text(text) if text == "success" => Final::Success,
        Data::Text(text) if text == "failure" => Final::Failure,
        _ => {
            let message = format!(
                "'final' of a state must be true, false, \"success\" or \"failure\", not {}",
                value.describe()
            );
            problems.add(value.place.into(), message);
            Final::No
        }
    }
}

fn during(fields: &Fields<'_>, state: &str, problems: &mut Collector) -> Option<DuringDef> {
    let value = fields.get("during")?;
    if value.as_text().is_some() {
        return Some(DuringDef {
            run: name_of(value, problems)?,
            success: None,
            failure: None,
        });
    }
    let fields = Fields::open(value, "'during'", DURING, problems)?;
    Some(DuringDef {
        run: run_name(&fields, state, problems)?,
        success: fields.name("success", problems),
        failure: fields.name("failure", problems),
    })
}

/// The sub-behaviour: a named one, or the steps written here, which have the name of their
/// state.
pub(crate) fn run_name(fields: &Fields<'_>, state: &str, problems: &mut Collector) -> Option<Name> {
    match (fields.get("steps"), fields.get("run")) {
        (Some(steps), None) => Some(Name {
            text: state.to_owned(),
            place: steps.place.into(),
        }),
        (Some(steps), Some(_)) => {
            let message = "'during' has 'run' and 'steps'; keep one of them";
            problems.add(steps.place.into(), message);
            None
        }
        // Also where both are missing: `run` is the key that the message asks for.
        (None, _) => fields.required("run", problems),
    }
}

fn row(value: &Value, problems: &mut Collector) -> Option<RowDef> {
    let fields = Fields::open(value, "a row", ROW, problems)?;
    let trigger = fields.required("trigger", problems);
    let source = source(&fields, problems);
    Some(RowDef {
        place: fields.place,
        dest: dest(&fields, problems)?,
        conditions: fields.names("conditions", problems),
        unless: fields.names("unless", problems),
        prepare: fields.names("prepare", problems),
        before: fields.names("before", problems),
        after: fields.names("after", problems),
        trigger: trigger?,
        source: source?,
    })
}

fn source(fields: &Fields<'_>, problems: &mut Collector) -> Option<SourceDef> {
    let value = fields.get("source");
    if value.and_then(Value::as_text) == Some("*") {
        return value.map(|value| SourceDef::Any(value.place.into()));
    }
    let names = fields.names("source", problems);
    if names.is_empty() {
        let place = value.map_or(fields.place, |value| value.place.into());
        problems.add(
            place,
            "a row has no source; name a state, a list of states, or \"*\"",
        );
        return None;
    }
    Some(SourceDef::These(names))
}

fn dest(fields: &Fields<'_>, problems: &mut Collector) -> Option<DestDef> {
    let internal = fields.flag("internal", false, problems);
    let value = fields.get("dest").filter(|value| value.data != Data::Null);
    let Some(value) = value else {
        return Some(DestDef::Internal);
    };
    let dest = match fields.name("dest", problems)? {
        name if name.text.is_empty() => return Some(DestDef::Internal),
        name if name.text == "=" => DestDef::Same,
        name => DestDef::To(name),
    };
    // `internal = true` with a destination is a contradiction; neither is silently preferred.
    if internal {
        let message = "a row has a dest and says internal = true; drop one of them";
        problems.add(value.place.into(), message);
    }
    Some(dest)
}

fn ordered(value: &Value, problems: &mut Collector) -> Option<OrderedDef> {
    let fields = Fields::open(value, "an ordered chain", ORDERED, problems)?;
    Some(OrderedDef {
        place: fields.place,
        trigger: fields.required("trigger", problems)?,
        states: fields.names("states", problems),
        cyclic: fields.flag("loop", true, problems),
        conditions: fields.names("conditions", problems),
        unless: fields.names("unless", problems),
    })
}
