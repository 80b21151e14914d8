//! The declarations of a file before its tree: constants, keys and subtrees.

use std::collections::BTreeMap;

use super::advice;
use super::build::Builder;
use super::declared::{Declared, SCOPES, Subtree, SubtreePort};
use super::error::Errors;
use super::files::{File, get, object};
use super::foreign;
use super::json::{Data, Entry, Value as Json, shortened};
use super::limits::{MAX_ENTRIES, MAX_NAME, MAX_PORTS};
use super::literal;
use crate::board::{Board, Scope};
use crate::tree::{Host, Library};
use crate::value::{Value, ValueType};

/// Keys of a file.
pub(super) const FILE_KEYS: &[&str] = &[
    "$schema",
    "format",
    "name",
    "doc",
    "constants",
    "blackboard",
    "includes",
    "leaves",
    "subtrees",
    "root",
];
/// Keys of the declaration of a blackboard key, and of a subtree's port.
pub(super) const KEY_KEYS: &[&str] = &["type", "default", "doc", "observed"];
/// Keys of a subtree.
pub(super) const SUBTREE_KEYS: &[&str] = &["doc", "ports", "root"];

/// Types of values.
pub(super) const TYPES: &[ValueType] = &[
    ValueType::Bool,
    ValueType::Integer,
    ValueType::Number,
    ValueType::Text,
    ValueType::Numbers,
    ValueType::Set,
];

/// Reads the headers of all files into a builder.
pub(super) fn read<'a, H: Host>(
    files: &'a [File],
    library: &'a Library<H>,
    instance: &BTreeMap<String, Value>,
    shared: &Board,
    errors: Errors,
) -> Builder<'a, H> {
    let mut builder = Builder::new(library, instance.clone(), shared.clone(), errors);
    let mut tops = Vec::new();
    for (index, file) in files.iter().enumerate() {
        let what = "a behaviour tree file";
        let known = FILE_KEYS;
        let Some(entries) = object(&mut builder.errors, &file.name, &file.root, what, known) else {
            continue;
        };
        // Two roots would leave open which one is the tree.
        if index > 0
            && let Some(root) = entries.iter().find(|e| e.key == "root")
        {
            let message = "an included file must not have a root; make it a subtree";
            builder.errors.push(&file.name, root.place, message);
        }
        tops.push((file.name.as_str(), entries));
    }
    // All constants first: keys, leaves and subtrees of every file may use them.
    for (file, entries) in &tops {
        constants(&mut builder, file, entries, instance);
    }
    for (file, entries) in &tops {
        blackboard(&mut builder, file, entries);
        foreign::leaves(&mut builder, file, entries);
        subtrees(&mut builder, file, entries);
    }
    builder
}

/// The entries of the group `key`, if the file has it; a group with too many is refused.
pub(super) fn group<'a>(
    errors: &mut Errors,
    file: &str,
    entries: &'a [Entry],
    key: &str,
) -> &'a [Entry] {
    let Some(value) = get(entries, key) else {
        return &[];
    };
    let Some(group) = value.as_object() else {
        let message = format!("an object is needed here, this is {}", value.describe());
        errors.push(file, value.place, message);
        return &[];
    };
    // Refused as a whole: each entry becomes a key of the board or is searched by name.
    if group.len() > MAX_ENTRIES {
        let message = format!("{} entries, at most {MAX_ENTRIES} are allowed", group.len());
        errors.push(file, value.place, message);
        return &[];
    }
    for entry in group {
        if entry.key.is_empty() || entry.key.len() > MAX_NAME {
            let message = format!(
                "a name has 1 to {MAX_NAME} bytes, this has {}",
                entry.key.len()
            );
            errors.push(file, entry.place, message);
        }
    }
    group
}

fn constants<'a, H: Host>(
    builder: &mut Builder<'a, H>,
    file: &'a str,
    entries: &'a [Entry],
    instance: &BTreeMap<String, Value>,
) {
    for entry in group(&mut builder.errors, file, entries, "constants") {
        let value = match literal::untyped(&entry.value) {
            Ok(value) => value,
            Err(message) => {
                builder.errors.push(file, entry.value.place, message);
                continue;
            }
        };
        let known = builder.declared_constants.iter();
        if let Some(first) = known.into_iter().find(|c| c.name == entry.key) {
            let message = format!(
                "constant '{}' is declared in {}:{}, too; keep one of them",
                shortened(&entry.key),
                first.file,
                first.place.line
            );
            builder.errors.push(file, entry.place, message);
            continue;
        }
        builder.declared_constants.push(Declared {
            name: entry.key.clone(),
            file,
            place: entry.place,
        });
        // A value of the instance replaces that of the file, with the type that the file
        // declares.
        let taken = match instance.get(&entry.key) {
            None => Ok(value),
            Some(given) => literal::coerced(*given, value.value_type()).ok_or(given),
        };
        match taken {
            Ok(value) => {
                builder.constants.insert(entry.key.clone(), value);
            }
            Err(given) => {
                let message = format!(
                    "constant '{}' is {}, but where the tree is used it is given {given}",
                    shortened(&entry.key),
                    value.value_type().name(),
                );
                builder.errors.push(file, entry.value.place, message);
            }
        }
    }
}

/// The declared type and default of a key or a port.
fn declaration<'a>(
    errors: &mut Errors,
    file: &str,
    value: &'a Json,
) -> Option<(ValueType, Option<&'a Json>)> {
    let entries = object(errors, file, value, "a declaration", KEY_KEYS)?;
    let names: Vec<&str> = TYPES.iter().map(|t| t.name()).collect();
    let Some(name) = get(entries, "type") else {
        let message = format!("\"type\" is missing; it is one of {}", names.join(", "));
        errors.push(file, value.place, message);
        return None;
    };
    let text = name.as_text().unwrap_or_default();
    let Some(value_type) = TYPES.iter().find(|t| t.name() == text) else {
        let found = name
            .as_text()
            .map_or_else(|| name.describe(), str::to_owned);
        errors.push(
            file,
            name.place,
            advice::unknown("type of value", &found, &names),
        );
        return None;
    };
    Some((*value_type, get(entries, "default")))
}

fn blackboard<'a, H: Host>(builder: &mut Builder<'a, H>, file: &'a str, entries: &'a [Entry]) {
    let Some(value) = get(entries, "blackboard") else {
        return;
    };
    let what = "the blackboard";
    let Some(scopes) = object(&mut builder.errors, file, value, what, SCOPES) else {
        return;
    };
    for (scope, name) in [(Scope::Local, "local"), (Scope::Shared, "shared")] {
        for entry in group(&mut builder.errors, file, scopes, name) {
            key(builder, file, scope, entry);
        }
    }
}

fn key<'a, H: Host>(builder: &mut Builder<'a, H>, file: &'a str, scope: Scope, entry: &'a Entry) {
    let name = builder.text(file, entry.place, &entry.key);
    let declared = declaration(&mut builder.errors, file, &entry.value);
    let Some(name) = name else { return };
    let Some((value_type, default)) = declared else {
        // Its uses are not reported in addition: they would all be unknown keys.
        builder.broken_keys.insert(name);
        return;
    };
    let given = default.map(|json| builder.literal(file, json, value_type));
    let Some(default) = given.map_or(Some(None), |given| given.map(Some)) else {
        builder.broken_keys.insert(name);
        return;
    };
    let board = builder.board(scope);
    match board.declare(&name, value_type, default) {
        Err(error) => builder.errors.push(file, entry.place, error.to_string()),
        Ok(index) => {
            if entry
                .value
                .get("observed")
                .is_some_and(|o| o.data == Data::Bool(true))
            {
                board.observe(index);
            }
            let first = board.keys().nth(index).and_then(|k| k.default);
            // The board keeps the first default, so a second one would be ignored without a
            // word.
            if first != default {
                let message = format!(
                    "blackboard key '{}' is declared with another default elsewhere; declare it once",
                    shortened(&name)
                );
                builder.errors.push(file, entry.place, message);
            }
            let place = entry.place;
            builder
                .declared_keys
                .push((scope, Declared { name, file, place }));
        }
    }
}

fn subtrees<'a, H: Host>(builder: &mut Builder<'a, H>, file: &'a str, entries: &'a [Entry]) {
    for entry in group(&mut builder.errors, file, entries, "subtrees") {
        let errors = &mut builder.errors;
        let Some(parts) = object(errors, file, &entry.value, "a subtree", SUBTREE_KEYS) else {
            continue;
        };
        let ports = ports(errors, file, parts);
        let Some(root) = get(parts, "root") else {
            errors.push(
                file,
                entry.value.place,
                "\"root\" is missing; give the subtree its node",
            );
            continue;
        };
        if let Some(first) = builder.subtrees.get(entry.key.as_str()) {
            let message = format!(
                "subtree '{}' is declared in {}:{}, too; keep one of them",
                shortened(&entry.key),
                first.file,
                first.place.line
            );
            errors.push(file, entry.place, message);
            continue;
        }
        let subtree = Subtree {
            file,
            place: entry.place,
            ports,
            root,
        };
        builder.subtrees.insert(&entry.key, subtree);
    }
}

fn ports<'a>(errors: &mut Errors, file: &str, parts: &'a [Entry]) -> Vec<SubtreePort<'a>> {
    let group = group(errors, file, parts, "ports");
    if let Some(beyond) = group.get(MAX_PORTS) {
        let message = format!("{} ports, at most {MAX_PORTS} are allowed", group.len());
        errors.push(file, beyond.place, message);
    }
    let mut ports = Vec::new();
    for entry in group.iter().take(MAX_PORTS) {
        if let Some((value_type, default)) = declaration(errors, file, &entry.value) {
            ports.push(SubtreePort {
                name: &entry.key,
                value_type,
                default,
            });
        }
    }
    ports
}
