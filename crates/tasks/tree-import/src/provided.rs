//! Leaves that a tree file provides: its subtrees with their names.

use std::collections::BTreeMap;
use std::path::Path;

use behavior::descriptor::{Errors, PortSignature, Signature, Source, signatures};
use behavior::suggest;
use behavior::value::ValueType;
use serde_json::Value as Json;

use crate::bind::{self, Value};
use crate::document::{Element, Model, PortModel};
use crate::emit::{no_text, number, truth};
use crate::leaves::holder;
use crate::out::{At, Bind};
use crate::translate::{Part, Translator};
use crate::types::{Holder, Type, Types};

/// The subtrees of the file.
#[derive(Debug, Default)]
pub(crate) struct Provided {
    /// The name by which the tree includes it.
    pub include: Option<String>,
    pub subtrees: BTreeMap<String, Signature>,
}

impl Provided {
    pub(crate) fn read(source: &Source<'_>) -> Result<Self, Errors> {
        let path = Path::new(source.file);
        let name = path.file_name().and_then(|name| name.to_str());
        Ok(Self {
            include: Some(name.unwrap_or(source.file).to_owned()),
            subtrees: signatures(source)?,
        })
    }
}

/// A subtree with its place, for messages.
pub(crate) fn named(name: &str, signature: &Signature) -> String {
    let (file, line) = (&signature.file, signature.place.line);
    format!("the subtree '{name}' ({file}:{line})")
}

/// A port of a provided leaf.
struct Target {
    value_type: ValueType,
    /// Its name in messages.
    port: String,
}

impl Target {
    /// Why a value does not fit the port.
    fn misfit(&self, found: &str) -> String {
        format!(
            "{} is of type {}, here it is {found}",
            self.port,
            self.value_type.name()
        )
    }

    /// The text of an attribute as a value of the type of the port.
    fn literal(&self, text: &str) -> Result<Json, String> {
        let word = text.trim();
        let value = match self.value_type {
            ValueType::Text => match no_text(text) {
                Some(why) => return Err(why),
                None => Some(text.into()),
            },
            ValueType::Bool => truth(word),
            ValueType::Number => number(word),
            ValueType::Integer => word.parse::<i64>().ok().map(Json::from),
            // The notation of vectors in BehaviorTree.CPP.
            ValueType::Numbers => {
                let items = word.split(';').map(|item| number(item.trim()));
                items.collect::<Option<Vec<_>>>().map(Json::Array)
            }
            ValueType::Set => None,
        };
        value.ok_or_else(|| self.misfit(&format!("'{text}'")))
    }
}

/// A key bound to a port of a provided leaf.
pub(crate) struct BoundKey {
    at: At,
    key: Holder,
    name: String,
    target: Target,
}

impl BoundKey {
    /// Compares the types, once all are known.
    pub(crate) fn check(&self, types: &Types, errors: &mut Errors) {
        let found = types.of(&self.key);
        if type_of(self.target.value_type) != Some(found) {
            let found = format!("the key '{}' of type {}", self.name, found.name());
            let message = format!("{}: {}", self.at.node, self.target.misfit(&found));
            errors.push(&self.at.file, self.at.place, message);
        }
    }
}

/// The type of a key with such values; keys of an import have no other types.
fn type_of(value_type: ValueType) -> Option<Type> {
    match value_type {
        ValueType::Bool => Some(Type::Bool),
        ValueType::Number => Some(Type::Number),
        ValueType::Text => Some(Type::Text),
        _ => None,
    }
}

impl Translator<'_> {
    /// A use of the subtree that provides a leaf.
    pub(crate) fn provided_leaf(
        &mut self,
        element: &Element,
        (name, signature): (&str, &Signature),
        model: Option<&Model>,
    ) -> Option<Part> {
        let own = named(name, signature);
        let mut out = self.out(element, "Subtree", Vec::new());
        out.subtree = Some(name.to_owned());
        let values = values(element, model);
        let ports: Vec<&str> = signature.ports.iter().map(|p| p.name.as_str()).collect();
        // Every port is tested before the use is refused, so that all mistakes are reported.
        let mut fits = true;
        for (port, text, access) in &values {
            let Some(declared) = signature.ports.iter().find(|p| p.name == *port) else {
                let advice = suggest::advice(port, &ports);
                self.refuse(element, format!("{own} has no port '{port}'; {advice}"));
                fits = false;
                continue;
            };
            match self.provided_port(element, (name, &own), declared, (text, *access)) {
                Some(bind) => out = out.bound(port, bind),
                None => fits = false,
            }
        }
        for port in signature.ports.iter().filter(|port| port.needed) {
            if !values.iter().any(|(name, ..)| *name == port.name) {
                self.refuse(element, format!("{own} needs the port '{}'", port.name));
                fits = false;
            }
        }
        fits.then(|| Part::of(out))
    }

    fn provided_port(
        &mut self,
        element: &Element,
        (name, own): (&str, &str),
        declared: &PortSignature,
        (text, access): (&str, Option<Access>),
    ) -> Option<Bind> {
        let port = declared.name.as_str();
        let target = Target {
            value_type: declared.value_type,
            port: format!("port '{port}' of {own}"),
        };
        let key = match bind::value(port, text) {
            // A literal has no place for the output of the leaf.
            Value::Text(_) if access.is_some_and(Access::is_output) => {
                let why = format!("{} is an output; bind it to a key, {{KEY}}", target.port);
                self.refuse(element, why);
                return None;
            }
            Value::Text(text) => match target.literal(text) {
                Ok(value) => return Some(Bind::Fixed(value)),
                Err(why) => {
                    self.refuse(element, why);
                    return None;
                }
            },
            // An unknown access may write.
            Value::Key(key) => self.key(key, access.is_none_or(|access| access.writes)),
        };
        let (of_port, of_key) = (holder(name, port), self.holder(&key));
        // A difference is reported when all types are known.
        if let Some(value_type) = type_of(target.value_type)
            && self.types.is(&of_port, value_type).is_ok()
        {
            self.types.takes(&of_port, &of_key);
        }
        self.bound.push(BoundKey {
            at: At::of(element),
            key: of_key,
            name: key.clone(),
            target,
        });
        Some(Bind::Key(key))
    }
}

/// The access of a port in the model.
#[derive(Clone, Copy)]
struct Access {
    reads: bool,
    writes: bool,
}

impl Access {
    fn of(port: &PortModel) -> Self {
        Self {
            reads: port.reads,
            writes: port.writes,
        }
    }

    fn is_output(self) -> bool {
        self.writes && !self.reads
    }
}

/// The bound ports with their texts: attributes, and defaults of the model.
fn values<'e>(
    element: &'e Element,
    model: Option<&'e Model>,
) -> Vec<(&'e str, &'e str, Option<Access>)> {
    let modelled = model
        .map(|model| model.ports.as_slice())
        .unwrap_or_default();
    let access = |name: &str| {
        let port = modelled.iter().find(|port| port.name == name);
        port.map(Access::of)
    };
    let attributes = element.attributes.iter();
    let attributes =
        attributes.filter(|(name, _)| name != "name" && name != "ID" && !name.starts_with('_'));
    let given = attributes.map(|(name, text)| (name.as_str(), text.as_str(), access(name)));
    let defaults = modelled.iter().filter_map(|port| {
        // An empty default means that there is none.
        let text = port.default.as_deref().filter(|text| !text.is_empty())?;
        let is_given = element.get(&port.name).is_some();
        (!is_given).then_some((port.name.as_str(), text, Some(Access::of(port))))
    });
    given.chain(defaults).collect()
}
