//! Leaves that a tree file provides: its subtrees with their names.

use std::collections::BTreeMap;
use std::path::Path;

use behavior::descriptor::{Errors, Signature, Source, signatures};
use behavior::value::ValueType;
use serde_json::Value as Json;

use crate::bind::{no_text, number, truth};
use crate::out::At;
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
pub(crate) struct Target {
    pub value_type: ValueType,
    /// Its name in messages.
    pub port: String,
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
    pub(crate) fn literal(&self, text: &str) -> Result<Json, String> {
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
    pub at: At,
    pub key: Holder,
    pub name: String,
    pub target: Target,
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
pub(crate) fn type_of(value_type: ValueType) -> Option<Type> {
    match value_type {
        ValueType::Bool => Some(Type::Bool),
        ValueType::Number => Some(Type::Number),
        ValueType::Text => Some(Type::Text),
        _ => None,
    }
}
