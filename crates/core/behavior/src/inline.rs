//! Behaviours written inside a machine or matrix file: steps of states and
//! handlers, and conditions of guards and events. Their node types are those of
//! the host, as in a tree.
//!
//! A step is a table: `do` names the node type, the other keys are its ports.
//! `not = true` inverts its result. `id`, `name`, `modifiers`, `children`, `as` and
//! `items` have the same meaning as in a tree.

use std::collections::BTreeMap;

use crate::board::Board;
use crate::descriptor::json::{Data, Entry, Location, Value as Json};
use crate::descriptor::{self, Errors};
use crate::machine::read::text;
use crate::machine::{Location as Place, Problem, Problems};
use crate::suggest;
use crate::tree::{Host, Library, Tree};

/// Keys of a step that are not ports.
const STEP_KEYS: &[&str] = &[
    "do",
    "id",
    "name",
    "doc",
    "not",
    "modifiers",
    "children",
    "as",
    "items",
];
/// Keys of a handler.
const HANDLER_KEYS: &[&str] = &["steps", "success", "failure"];

/// A named list of steps, or a named condition.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its name: that of the state, the handler, the guard or the event.
    pub name: String,
    /// A handler's event that is pending once its steps succeeded.
    pub success: Option<String>,
    /// A handler's event that is pending once a step has failed.
    pub failure: Option<String>,
    place: Location,
    steps: Json,
}

/// The parts of a machine or matrix file that the host implements.
#[derive(Clone, Debug, Default)]
pub struct Inline {
    /// Steps that states run, by the name of the state.
    pub states: Vec<Part>,
    /// Conditions of guards, by the name of the guard.
    pub conditions: Vec<Part>,
    /// Conditions that make an event pending or fire a trigger, by its name.
    pub events: Vec<Part>,
    /// Steps that handlers of a matrix start, by the name of the handler.
    pub handlers: Vec<Part>,
}

impl Inline {
    /// Reads these parts of a file.
    ///
    /// # Errors
    /// Every mistake in their shape, with its place.
    pub fn read(file: &str, text: &str) -> Result<Self, Problems> {
        let root = text::parse(file, text)?;
        let mut reader = Reader {
            problems: Vec::new(),
        };
        let mut inline = Self::default();
        for state in list(root.get("states")) {
            reader.state(state, "", &mut inline.states);
        }
        inline.conditions = reader.conditions(root.get("conditions"));
        inline.events = reader.conditions(root.get("events"));
        for entry in entries(root.get("handlers")) {
            inline.handlers.extend(reader.handler(entry));
        }
        if reader.problems.is_empty() {
            return Ok(inline);
        }
        Err(Problems::new(file, reader.problems))
    }
}

impl Part {
    /// The node types in it, with line and column.
    pub fn types(&self) -> Vec<(&str, u32, u32)> {
        let mut all = Vec::new();
        let mut open: Vec<&Json> = list(Some(&self.steps)).iter().collect();
        while let Some(step) = open.pop() {
            let named = step.get("do").and_then(Json::as_text);
            all.extend(named.map(|name| (name, step.place.line, step.place.column)));
            open.extend(list(step.get("children")));
        }
        all
    }

    /// The node type of its last step.
    pub fn last_type(&self) -> Option<&str> {
        let last = list(Some(&self.steps)).last()?;
        last.get("do").and_then(Json::as_text)
    }

    /// The tree of its steps: a sequence in which each step runs until it has succeeded.
    ///
    /// # Errors
    /// All mistakes in them, with line and column.
    pub fn tree<H: Host>(
        &self,
        file: &str,
        library: &Library<H>,
        shared: &mut Board,
    ) -> Result<Tree<H>, Errors> {
        // Ids are made of the part and the number of the step, so state survives a reload.
        let children = list(Some(&self.steps)).iter().enumerate();
        let children = children.map(|(index, step)| node(step, &format!("{}.{index}", self.name)));
        // The steps become a node of a tree file, so all rules of trees apply, with their
        // places.
        let root = object(
            self.place,
            [
                ("id", text_value(self.place, &self.name)),
                ("type", text_value(self.place, "Sequence")),
                (
                    "ports",
                    object(
                        self.place,
                        [("memory", value(self.place, Data::Bool(true)))],
                    ),
                ),
                (
                    "children",
                    value(self.place, Data::List(children.collect())),
                ),
            ],
        );
        descriptor::load_node(file, &self.name, &root, library, &BTreeMap::new(), shared)
    }
}

struct Reader {
    problems: Vec<Problem>,
}

impl Reader {
    fn add(&mut self, place: Location, message: String) {
        self.problems.push(Problem {
            place: Place::from(place),
            message,
        });
    }

    fn state(&mut self, state: &Json, parent: &str, out: &mut Vec<Part>) {
        // A state without a name is reported by the reader of machines.
        let Some(name) = state.get("name").and_then(Json::as_text) else {
            return;
        };
        let full = match parent {
            "" => name.to_owned(),
            parent => format!("{parent}.{name}"),
        };
        if let Some(steps) = state.get("during").and_then(|during| during.get("steps")) {
            out.extend(self.part(&full, state.place, steps));
        }
        for child in list(state.get("children")) {
            self.state(child, &full, out);
        }
    }

    fn conditions(&mut self, table: Option<&Json>) -> Vec<Part> {
        let entries = entries(table).iter();
        let part = |entry: &Entry| {
            let steps = value(entry.value.place, Data::List(vec![entry.value.clone()]));
            self.part(&entry.key, entry.place, &steps)
        };
        entries.filter_map(part).collect()
    }

    fn handler(&mut self, entry: &Entry) -> Option<Part> {
        let steps = entry.value.get("steps");
        for key in entries(Some(&entry.value)) {
            if !HANDLER_KEYS.contains(&key.key.as_str()) {
                let advice = suggest::advice(&key.key, HANDLER_KEYS);
                let message = format!("a handler has no key '{}'; {advice}", key.key);
                self.add(key.place, message);
            }
        }
        let Some(steps) = steps else {
            let message = format!("handler '{}' has no steps; add steps = [..]", entry.key);
            self.add(entry.place, message);
            return None;
        };
        let word = |key: &str| entry.value.get(key).and_then(Json::as_text);
        let part = self.part(&entry.key, entry.place, steps)?;
        Some(Part {
            success: word("success").map(str::to_owned),
            failure: word("failure").map(str::to_owned),
            ..part
        })
    }

    fn part(&mut self, name: &str, place: Location, steps: &Json) -> Option<Part> {
        if list(Some(steps)).is_empty() && steps.as_list().is_some() {
            let message = format!("'{name}' has no steps; give it at least one");
            self.add(steps.place, message);
        }
        if steps.as_list().is_none() {
            let message = format!("a list of steps is needed here, not {}", steps.describe());
            self.add(steps.place, message);
            return None;
        }
        // Only the shape is checked here; types and ports are checked with the library of the
        // host.
        for step in list(Some(steps)) {
            self.check_step(step);
        }
        Some(Part {
            name: name.to_owned(),
            success: None,
            failure: None,
            place,
            steps: steps.clone(),
        })
    }

    fn check_step(&mut self, step: &Json) {
        if step.get("do").and_then(Json::as_text).is_none() {
            let message = "a step is a table with do = \"NODE TYPE\" and its ports".to_owned();
            self.add(step.place, message);
        }
        for child in list(step.get("children")) {
            self.check_step(child);
        }
    }
}

/// A step in the form of a node of a tree.
fn node(step: &Json, id: &str) -> Json {
    let place = step.place;
    let given = |key: &str| step.get(key).cloned();
    let ports: Vec<Entry> = entries(Some(step))
        .iter()
        .filter(|entry| !STEP_KEYS.contains(&entry.key.as_str()))
        .cloned()
        .collect();
    let mut parts = vec![
        ("id", given("id").unwrap_or_else(|| text_value(place, id))),
        ("type", given("do").unwrap_or_else(|| text_value(place, ""))),
        ("ports", value(place, Data::Object(ports))),
    ];
    for key in ["name", "as", "items"] {
        parts.extend(given(key).map(|value| (key, value)));
    }
    let mut modifiers: Vec<Json> = list(step.get("modifiers")).to_vec();
    // The outermost modifier: it inverts the result of the step with its other modifiers.
    if step
        .get("not")
        .is_some_and(|not| not.data == Data::Bool(true))
    {
        let invert = [("type", text_value(place, "InvertStatus"))];
        modifiers.insert(0, object(place, invert));
    }
    if !modifiers.is_empty() {
        parts.push(("modifiers", value(place, Data::List(modifiers))));
    }
    if let Some(children) = step.get("children") {
        let inner = list(Some(children)).iter().enumerate();
        let inner = inner.map(|(index, child)| node(child, &format!("{id}.{index}")));
        parts.push((
            "children",
            value(children.place, Data::List(inner.collect())),
        ));
    }
    object(place, parts)
}

fn list(value: Option<&Json>) -> &[Json] {
    value.and_then(Json::as_list).unwrap_or_default()
}

fn entries(value: Option<&Json>) -> &[Entry] {
    value.and_then(Json::as_object).unwrap_or_default()
}

fn value(place: Location, data: Data) -> Json {
    Json { place, data }
}

fn text_value(place: Location, text: &str) -> Json {
    value(place, Data::Text(text.to_owned()))
}

fn object<'k>(place: Location, parts: impl IntoIterator<Item = (&'k str, Json)>) -> Json {
    let entry = |(key, value): (&str, Json)| Entry {
        key: key.to_owned(),
        place: value.place,
        value,
    };
    value(place, Data::Object(parts.into_iter().map(entry).collect()))
}
