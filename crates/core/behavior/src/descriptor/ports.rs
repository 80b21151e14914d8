//! Ports of nodes: those of registered types and those of the engine.

use std::collections::BTreeMap;

use super::advice;
use super::build::{Builder, NodeContext};
use super::engine::{EnginePort, EngineType, Shape};
use super::json::{self, Data, Entry, Location, Value as Json};
use super::limits::MAX_PORTS;
use super::literal;
use crate::tree::{Binding, Direction, Host, NodeType, PortSpec};
use crate::value::{Value, ValueType};

/// The ports of a node of the engine, checked against its table.
pub(super) struct EnginePorts {
    bound: BTreeMap<&'static str, (Binding, Location)>,
}

impl EnginePorts {
    /// The binding of the port, or its default.
    pub(super) fn get(&self, name: &str) -> Option<&Binding> {
        self.bound.get(name).map(|(binding, _)| binding)
    }

    /// The place of the binding.
    pub(super) fn place(&self, name: &str) -> Option<Location> {
        self.bound.get(name).map(|(_, place)| *place)
    }

    pub(super) fn literal(&self, name: &str) -> Option<Value> {
        match self.get(name) {
            Some(Binding::Literal(value)) => Some(*value),
            _ => None,
        }
    }

    pub(super) fn bool(&self, name: &str) -> bool {
        self.literal(name) == Some(Value::Bool(true))
    }

    pub(super) fn count(&self, name: &str) -> Option<u32> {
        match self.literal(name) {
            Some(Value::Integer(count)) => u32::try_from(count).ok(),
            _ => None,
        }
    }

    /// Index of the word among `words`.
    pub(super) fn choice(&self, name: &str, words: &[&str]) -> usize {
        match self.literal(name) {
            Some(Value::Text(text)) => words.iter().position(|word| *word == text.as_str()),
            _ => None,
        }
        .unwrap_or(0)
    }
}

impl<'a, H: Host> Builder<'a, H> {
    /// The entries of `ports`; unknown ports, and too many, are reported.
    pub(super) fn port_entries(
        &mut self,
        context: &NodeContext<'a>,
        ports: Option<&'a Json>,
        known: &[&str],
    ) -> &'a [Entry] {
        let Some(ports) = ports else { return &[] };
        let Some(entries) = ports.as_object() else {
            let message = format!(
                "an object of ports is needed here, this is {}",
                ports.describe()
            );
            self.errors.push(context.file, ports.place, message);
            return &[];
        };
        if entries.len() > MAX_PORTS {
            let message = format!("{} ports, at most {MAX_PORTS} are allowed", entries.len());
            self.errors.push(context.file, ports.place, message);
            return &[];
        }
        for entry in entries {
            if !known.contains(&entry.key.as_str()) && !self.errors.is_full() {
                let message = advice::unknown("port", &entry.key, known);
                self.errors.push(context.file, entry.place, message);
            }
        }
        entries
    }

    /// The bindings of the ports of a registered type; `None` for a mistake,
    /// which is reported.
    pub(super) fn bindings(
        &mut self,
        context: &NodeContext<'a>,
        place: Location,
        ports: Option<&'a Json>,
        node_type: &NodeType<H>,
    ) -> Option<BTreeMap<String, Binding>> {
        let names = node_type.ports.iter().map(|p| p.name);
        let aliases = node_type.ports.iter().flat_map(|p| p.aliases);
        let known: Vec<&str> = names.chain(aliases.copied()).collect();
        let entries = self.port_entries(context, ports, &known);
        let mut bindings = Some(BTreeMap::new());
        for port in &node_type.ports {
            let mut given = entries.iter().filter(|e| port.is_called(&e.key));
            let entry = given.next();
            // A port may be given by its name and by an alias.
            if let Some(twice) = given.next() {
                let message = format!("port '{}' is given twice; keep one", port.name);
                self.errors.push(context.file, twice.place, message);
            }
            let binding = match (entry, port.default) {
                (Some(entry), _) => self.port(context, &entry.value, port),
                (None, Some(default)) => Some(Binding::Literal(default)),
                (None, None) => {
                    self.errors
                        .push(context.file, place, missing(node_type.name, port));
                    None
                }
            };
            match (binding, &mut bindings) {
                (Some(binding), Some(all)) => drop(all.insert(port.name.to_owned(), binding)),
                _ => bindings = None,
            }
        }
        bindings
    }

    fn port(
        &mut self,
        context: &NodeContext<'a>,
        json: &'a Json,
        port: &PortSpec,
    ) -> Option<Binding> {
        let binding = self.binding(context, json, Some(port.value_type))?;
        let Binding::Literal(value) = binding else {
            return Some(binding);
        };
        let wrong = match port.direction {
            // The engine writes results to keys only; a literal has no place for them.
            Direction::Out => Some(format!(
                "port '{}' is written; bind it to a key: {{\"bb\": \"local.KEY\"}}",
                port.name
            )),
            Direction::In => out_of_bounds(value, port),
        };
        match wrong {
            None => Some(Binding::Literal(value)),
            Some(message) => {
                self.errors.push(context.file, json.place, message);
                None
            }
        }
    }

    /// The ports of a type of the engine; `None` for a mistake.
    pub(super) fn engine_ports(
        &mut self,
        context: &NodeContext<'a>,
        place: Location,
        ports: Option<&'a Json>,
        spec: &'static EngineType,
    ) -> Option<EnginePorts> {
        let known: Vec<&str> = spec.ports.iter().map(|p| p.name).collect();
        let entries = self.port_entries(context, ports, &known);
        let mut bound = BTreeMap::new();
        let mut whole = true;
        // Ids of children are resolved by the parallel, which knows the children.
        for port in spec.ports.iter().filter(|p| p.shape != Shape::Ids) {
            let entry = entries.iter().find(|e| e.key == port.name);
            let binding = match (entry, port.default) {
                (Some(entry), _) => self
                    .engine_port(context, &entry.value, port)
                    .map(|binding| (binding, entry.value.place)),
                (None, Some(default)) => default_of(default).map(|b| (b, place)),
                (None, None) if port.required => {
                    let message =
                        format!("{} needs the port '{}': {}", spec.name, port.name, port.doc);
                    self.errors.push(context.file, place, message);
                    None
                }
                (None, None) => continue,
            };
            match binding {
                Some(binding) => drop(bound.insert(port.name, binding)),
                None => whole = false,
            }
        }
        whole.then_some(EnginePorts { bound })
    }

    fn engine_port(
        &mut self,
        context: &NodeContext<'a>,
        json: &'a Json,
        port: &EnginePort,
    ) -> Option<Binding> {
        let wanted = match port.shape {
            Shape::Bool => Some(ValueType::Bool),
            Shape::Count(_) => Some(ValueType::Integer),
            Shape::Choice(_) => Some(ValueType::Text),
            Shape::Seconds | Shape::Number => Some(ValueType::Number),
            Shape::Value | Shape::Bound | Shape::Key | Shape::Ids => None,
        };
        if port.shape == Shape::Key && !matches!(json.data, Data::Object(_)) {
            let message = format!(
                "a key is needed here, {{\"bb\": \"local.KEY\"}}; this is {}",
                json.describe()
            );
            self.errors.push(context.file, json.place, message);
            return None;
        }
        let binding = self.binding(context, json, wanted)?;
        match shape_mistake(port, &binding) {
            None => Some(binding),
            Some(message) => {
                self.errors.push(context.file, json.place, message);
                None
            }
        }
    }
}

/// The default of a port, from the table.
fn default_of(text: &str) -> Option<Binding> {
    let json = json::parse("", text).ok()?;
    literal::untyped(&json).ok().map(Binding::Literal)
}

fn missing(type_name: &str, port: &PortSpec) -> String {
    let wanted = match port.direction {
        Direction::In => literal::wanted(port.value_type),
        Direction::Out => format!("a key of type {}", port.value_type.name()),
    };
    format!(
        "{type_name} needs the port '{}' ({}), {wanted}",
        port.name, port.doc
    )
}

/// The mistake in a literal of the right type.
fn out_of_bounds(value: Value, port: &PortSpec) -> Option<String> {
    let name = port.name;
    if let Some((low, high)) = port.range {
        let inside = |number: f64| (low..=high).contains(&number);
        let fits = match value {
            Value::Integer(integer) => inside(integer as f64),
            Value::Number(number) => inside(number),
            Value::Numbers(numbers) => numbers.as_slice().iter().all(|n| inside(*n)),
            _ => true,
        };
        if !fits {
            return Some(format!(
                "port '{name}' is {value}, allowed is {low} to {high}"
            ));
        }
    }
    match value {
        Value::Text(text) if !port.choices.is_empty() && !port.choices.contains(&text.as_str()) => {
            let advice = advice::advice(text.as_str(), port.choices);
            Some(format!("port '{name}' cannot be '{text}'; {advice}"))
        }
        _ => None,
    }
}

/// The mistake in the binding of a port of the engine.
fn shape_mistake(port: &EnginePort, binding: &Binding) -> Option<String> {
    let name = port.name;
    match (port.shape, binding) {
        (Shape::Key, Binding::Literal(value)) => Some(format!(
            "port '{name}' is {value}, a key is needed: {{\"bb\": \"local.KEY\"}}"
        )),
        (Shape::Seconds, Binding::Literal(Value::Number(seconds))) if *seconds < 0.0 => {
            Some(format!("port '{name}' is {seconds} s, 0 or more is needed"))
        }
        (Shape::Seconds | Shape::Key | Shape::Bound, _) => None,
        // Counts, tests and words are part of the node, which does not change after loading.
        (_, Binding::Key(..)) => Some(format!(
            "port '{name}' has to be a value that is known when the file is loaded"
        )),
        (Shape::Count(least), Binding::Literal(Value::Integer(count))) => {
            let fits = *count >= i64::from(least) && *count <= i64::from(u32::MAX);
            (!fits).then(|| {
                format!(
                    "port '{name}' is {count}, {least} to {} is needed",
                    u32::MAX
                )
            })
        }
        (Shape::Choice(words), Binding::Literal(Value::Text(word))) => {
            let known = words.contains(&word.as_str());
            (!known).then(|| {
                let advice = advice::advice(word.as_str(), words);
                format!("port '{name}' cannot be '{word}'; {advice}")
            })
        }
        _ => None,
    }
}
