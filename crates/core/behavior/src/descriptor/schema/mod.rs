//! The JSON Schema of tree files, made from the registered node types, with which
//! an editor completes and checks them.

mod ports;
mod values;

use serde_json::{Map, Value as Json, json};

use super::engine::{self, Children, EngineType};
use super::files::FORMAT;
use super::header::TYPES;
use super::limits::{MAX_ENTRIES, MAX_NAME, MAX_PORTS};
use crate::tree::{Host, Library};
use ports::{engine_ports, registered_ports, with_ports};
use values::{bound, declaration, plain};

/// The schema (draft 2020-12) of the files that can be read with `library`.
pub fn schema<H: Host>(library: &Library<H>) -> Json {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Behaviour tree",
        "description": "A tree of behaviours with its declarations, or parts for other files to include",
        "type": "object",
        "properties": {
            "$schema": {"type": "string"},
            "format": {"const": FORMAT, "description": "Version of the format"},
            "name": name("Name of the tree; constants are replaced"),
            "doc": {"type": "string", "description": "Purpose of the tree"},
            "constants": {
                "description": "Values used as ${NAME}; where the tree is used they may be replaced",
                "type": "object",
                "maxProperties": MAX_ENTRIES,
                "additionalProperties": {"anyOf": [
                    {"type": ["boolean", "number", "string"]},
                    plain(crate::ValueType::Numbers),
                ]},
            },
            "blackboard": {
                "description": "Keys with their types and defaults",
                "type": "object",
                "properties": {
                    "local": keys("Keys of this tree"),
                    "shared": keys("Keys shared by all trees of the host"),
                },
                "additionalProperties": false,
            },
            "includes": {
                "description": "Files whose constants, keys and subtrees are used",
                "type": "array",
                "items": {"type": "string"},
            },
            "leaves": {
                "description": "Leaf types that another program provides, a Python file for example",
                "type": "object",
                "maxProperties": MAX_ENTRIES,
                "additionalProperties": super::foreign::describe(),
            },
            "subtrees": {
                "description": "Parts that are used by nodes of the type Subtree",
                "type": "object",
                "maxProperties": MAX_ENTRIES,
                "additionalProperties": {"$ref": "#/$defs/subtree"},
            },
            "root": {"$ref": "#/$defs/node"},
        },
        "required": ["format"],
        "dependentRequired": {"root": ["name"]},
        "additionalProperties": false,
        "$defs": definitions(library),
    })
}

fn definitions<H: Host>(library: &Library<H>) -> Json {
    json!({
        "key": {
            "description": "A blackboard key",
            "type": "object",
            "properties": {"bb": {
                "type": "string",
                "pattern": "^(local|shared)\\..",
                "description": "'local.KEY' or 'shared.KEY'",
            }},
            "required": ["bb"],
            "additionalProperties": false,
        },
        "port": {
            "description": "A port of the subtree this is in",
            "type": "object",
            "properties": {"port": {"type": "string"}},
            "required": ["port"],
            "additionalProperties": false,
        },
        "constant": {
            "description": "A constant, ${NAME}",
            "type": "string",
            "pattern": "^\\$\\{[^{}$]*\\}$",
        },
        "declaration": declaration(),
        "subtree": {
            "type": "object",
            "properties": {
                "doc": {"type": "string"},
                "ports": {
                    "type": "object",
                    "maxProperties": MAX_PORTS,
                    "additionalProperties": {"$ref": "#/$defs/declaration"},
                },
                "root": {"$ref": "#/$defs/node"},
            },
            "required": ["root"],
            "additionalProperties": false,
        },
        "node": node(library),
        "guard": guard(library),
        "modifier": modifier(),
    })
}

fn name(doc: &str) -> Json {
    json!({"type": "string", "minLength": 1, "maxLength": MAX_NAME, "description": doc})
}

fn keys(doc: &str) -> Json {
    json!({
        "description": doc,
        "type": "object",
        "maxProperties": MAX_ENTRIES,
        "additionalProperties": {"$ref": "#/$defs/declaration"},
    })
}

/// A type as an editor offers it: its name and its description.
fn offer(name: &str, doc: &str, keywords: &[&str]) -> Json {
    let description = match keywords {
        [] => doc.to_owned(),
        _ => format!("{doc} ({})", keywords.join(", ")),
    };
    json!({"const": name, "description": description})
}

fn engine_offer(t: &EngineType) -> Json {
    offer(t.name, t.doc, t.keywords)
}

fn registered_offers<H: Host>(library: &Library<H>) -> Vec<Json> {
    let mut offers = Vec::new();
    for t in library.types() {
        offers.push(offer(t.name, t.doc, t.keywords));
        // Accepted, so that older files are valid, and marked, so that new ones do not use
        // them.
        for alias in t.aliases {
            let description = format!("Older name of {}", t.name);
            offers.push(json!({"const": alias, "description": description, "deprecated": true}));
        }
    }
    offers
}

/// `then` for the nodes of the type `name`.
fn case(name: &str, then: &Json) -> Json {
    json!({
        "if": {"properties": {"type": {"const": name}}, "required": ["type"]},
        "then": then,
    })
}

fn node<H: Host>(library: &Library<H>) -> Json {
    let mut offers = registered_offers(library);
    offers.extend(engine::NODES.iter().map(engine_offer));
    let mut cases = registered_cases(library, true);
    cases.extend(engine::NODES.iter().map(|t| case(t.name, &engine_node(t))));
    json!({
        "type": "object",
        "properties": {
            "id": {
                "type": "string",
                "maxLength": MAX_NAME,
                "pattern": "^[^\\s/]+$",
                "description": "Stable and unique in the tree: state is carried over by it",
            },
            "type": {"anyOf": offers},
            "name": name("Name for people; constants are replaced"),
            "doc": {"type": "string"},
            "ports": {"type": "object"},
            "modifiers": {
                "description": "Modifiers of the node, the outermost first",
                "type": "array",
                "maxItems": MAX_PORTS,
                "items": {"$ref": "#/$defs/modifier"},
            },
            "children": {"type": "array", "items": {"$ref": "#/$defs/node"}},
            "subtree": {"type": "string", "description": "Name of the subtree"},
            "guard": {"$ref": "#/$defs/guard"},
            "as": values::item_name(),
            "items": values::items(),
        },
        "required": ["type"],
        "additionalProperties": false,
        "allOf": cases,
    })
}

fn guard<H: Host>(library: &Library<H>) -> Json {
    const CONDITION: &str = "CheckBlackboard";
    const SET: &str = "SetBlackboard";
    let mut offers = registered_offers(library);
    let mut cases = registered_cases(library, false);
    for t in [CONDITION, SET].into_iter().filter_map(engine::find) {
        offers.push(engine_offer(t));
        cases.push(case(t.name, &json!(with_ports(engine_ports(t)))));
    }
    json!({
        "description": "Asked before each tick of the child",
        "type": "object",
        "properties": {
            "type": {"anyOf": offers},
            "doc": {"type": "string"},
            "ports": {"type": "object"},
        },
        "required": ["type"],
        "additionalProperties": false,
        "allOf": cases,
    })
}

fn modifier() -> Json {
    let offers: Vec<Json> = engine::MODIFIERS.iter().map(engine_offer).collect();
    let mut cases = Vec::new();
    for t in engine::MODIFIERS {
        let mut then = with_ports(engine_ports(t));
        if t.name != super::modifiers::CHECK {
            let properties = then.entry("properties").or_insert_with(|| json!({}));
            // `false` refuses the key: only a check of a key has an abort mode.
            if let Some(properties) = properties.as_object_mut() {
                properties.insert("abort".to_owned(), json!(false));
            }
        }
        cases.push(case(t.name, &Json::Object(then)));
    }
    json!({
        "type": "object",
        "properties": {
            "type": {"anyOf": offers},
            "doc": {"type": "string"},
            "abort": {
                "enum": engine::ABORTS,
                "default": "none",
                "description": "Nodes that it interrupts when its answer changes: none, its own node \
                                when it does not hold any more, siblings to the right when it \
                                holds again, or both",
            },
            "ports": {"type": "object"},
        },
        "required": ["type"],
        "additionalProperties": false,
        "allOf": cases,
    })
}

fn registered_cases<H: Host>(library: &Library<H>, of_nodes: bool) -> Vec<Json> {
    let mut cases = Vec::new();
    for t in library.types() {
        let mut then = with_ports(registered_ports(t));
        if of_nodes {
            restrict(&mut then, Children::None, t.name);
        }
        let then = Json::Object(then);
        cases.extend(
            std::iter::once(&t.name)
                .chain(t.aliases)
                .map(|n| case(n, &then)),
        );
    }
    cases
}

fn engine_node(t: &EngineType) -> Json {
    // Its ports are those of the subtree, which the schema does not know.
    if t.name == engine::SUBTREE {
        let mut then = Map::new();
        then.insert("properties".to_owned(), json!({
            "ports": {"type": "object", "maxProperties": MAX_PORTS, "additionalProperties": bound(None)},
        }));
        restrict(&mut then, t.children, t.name);
        return Json::Object(then);
    }
    let mut then = with_ports(engine_ports(t));
    restrict(&mut then, t.children, t.name);
    Json::Object(then)
}

/// Adds the keys of a type besides its ports.
fn restrict(then: &mut Map<String, Json>, children: Children, name: &str) {
    let mut required: Vec<&str> = Vec::new();
    let mut add = Map::new();
    match children {
        Children::None => drop(add.insert("children".to_owned(), json!({"maxItems": 0}))),
        Children::One => {
            add.insert("children".to_owned(), json!({"minItems": 1, "maxItems": 1}));
            required.push("children");
        }
        Children::Any => {}
    }
    for (key, owner) in engine::OWNED_KEYS {
        if name == owner {
            required.push(key);
        } else {
            // Keys of other types are refused, as the loader does.
            add.insert(key.to_owned(), json!(false));
        }
    }
    let properties = then.entry("properties").or_insert_with(|| json!({}));
    if let Some(properties) = properties.as_object_mut() {
        properties.extend(add);
    }
    let all = then.entry("required").or_insert_with(|| json!([]));
    if let Some(all) = all.as_array_mut() {
        all.extend(required.into_iter().map(|key| json!(key)));
    }
}

/// Names of the types of values.
fn type_names() -> Vec<&'static str> {
    TYPES.iter().map(|t| t.name()).collect()
}
