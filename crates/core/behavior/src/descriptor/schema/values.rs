//! Schemas of values and of bindings of ports.

use serde_json::{Value as Json, json};

use super::type_names;
use crate::descriptor::header::TYPES;
use crate::descriptor::limits::{MAX_NAME, MAX_NODES};
use crate::value::{MAX_NUMBERS, STR_BYTES, Value, ValueType};

/// A literal of that type.
pub(super) fn plain(value_type: ValueType) -> Json {
    match value_type {
        ValueType::Bool => json!({"type": "boolean"}),
        ValueType::Integer => json!({"type": "integer"}),
        ValueType::Number => json!({"type": "number"}),
        ValueType::Text => json!({"type": "string", "maxLength": STR_BYTES}),
        ValueType::Numbers => json!({
            "type": "array", "maxItems": MAX_NUMBERS, "items": {"type": "number"},
        }),
        ValueType::Set => json!({
            "type": "array", "items": {"type": "integer", "minimum": 0, "maximum": 63},
        }),
    }
}

/// A literal of that type within the bounds of a port.
pub(super) fn within(value_type: ValueType, range: Option<(f64, f64)>, choices: &[&str]) -> Json {
    let mut schema = plain(value_type);
    if value_type == ValueType::Text && !choices.is_empty() {
        return json!({"enum": choices});
    }
    if let Some((low, high)) = range {
        let bounded = match value_type {
            ValueType::Numbers => schema.get_mut("items"),
            ValueType::Integer | ValueType::Number => Some(&mut schema),
            _ => None,
        };
        if let Some(bounded) = bounded.and_then(Json::as_object_mut) {
            bounded.insert("minimum".to_owned(), json!(low));
            bounded.insert("maximum".to_owned(), json!(high));
        }
    }
    schema
}

/// The literal, or a form that is replaced by one when the file is loaded.
pub(super) fn literal(value_type: ValueType, literal: Json) -> Json {
    let mut ways = ways(value_type, literal);
    ways.push(json!({"$ref": "#/$defs/port"}));
    json!({"anyOf": ways})
}

fn ways(value_type: ValueType, literal: Json) -> Vec<Json> {
    let constant = match value_type {
        // A text may contain constants, other values are replaced as a whole.
        ValueType::Text => json!({"type": "string", "pattern": "\\$\\{[^{}$]*\\}"}),
        _ => json!({"$ref": "#/$defs/constant"}),
    };
    vec![literal, constant]
}

/// Any literal known at load.
pub(super) fn any_literal() -> Json {
    json!({"anyOf": [
        {"type": ["boolean", "number", "string"]},
        {"type": "array", "items": {"type": "number"}},
        {"$ref": "#/$defs/port"},
    ]})
}

/// A literal of a type, or of any; a port of the subtree around; or a key.
pub(super) fn bound(typed: Option<(ValueType, Json)>) -> Json {
    let mut schema = match typed {
        Some((value_type, plain)) => literal(value_type, plain),
        None => any_literal(),
    };
    if let Some(ways) = schema.get_mut("anyOf").and_then(Json::as_array_mut) {
        ways.push(json!({"$ref": "#/$defs/key"}));
    }
    schema
}

/// A key, directly or by a port of the subtree.
pub(super) fn key_only() -> Json {
    json!({"anyOf": [{"$ref": "#/$defs/key"}, {"$ref": "#/$defs/port"}]})
}

/// Adds the description and the default that an editor shows.
pub(super) fn describe(schema: &mut Json, doc: &str, default: Option<Json>) {
    if let Some(schema) = schema.as_object_mut() {
        schema.insert("description".to_owned(), json!(doc));
        if let Some(default) = default {
            schema.insert("default".to_owned(), default);
        }
    }
}

/// A default in the form of the file.
pub(super) fn example(value: Value) -> Json {
    match value {
        Value::Bool(value) => json!(value),
        Value::Integer(value) => json!(value),
        Value::Number(value) => json!(value),
        Value::Text(text) => json!(text.as_str()),
        Value::Numbers(numbers) => json!(numbers.as_slice()),
        Value::Set(set) => json!(set.items().collect::<Vec<u32>>()),
    }
}

/// The declaration of a key or of a port of a subtree.
pub(super) fn declaration() -> Json {
    let mut cases = Vec::new();
    for value_type in TYPES {
        let default = json!({"anyOf": ways(*value_type, plain(*value_type))});
        cases.push(super::case(
            value_type.name(),
            &json!({"properties": {"default": default}}),
        ));
    }
    json!({
        "type": "object",
        "properties": {
            "type": {"enum": type_names(), "description": "Type of its value"},
            "default": {"description": "Its value after a reset, or where a port is not bound"},
            "doc": {"type": "string", "description": "Purpose, with its unit"},
        },
        "required": ["type"],
        "additionalProperties": false,
        "allOf": cases,
    })
}

/// The name of the item of a `ForEach`.
pub(super) fn item_name() -> Json {
    json!({
        "description": "Name of the item: ${NAME} in the child is the item; no name of a constant",
        "type": "string",
        "minLength": 1,
        "maxLength": MAX_NAME,
        "pattern": "^[^\\s${}]+$",
    })
}

/// The items of a `ForEach`.
pub(super) fn items() -> Json {
    json!({
        "description": "Values, one copy of the child for each",
        "type": "array",
        "maxItems": MAX_NODES,
        "items": {"anyOf": [
            {"type": ["boolean", "number", "string"]},
            plain(ValueType::Numbers),
        ]},
    })
}
