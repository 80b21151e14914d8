//! The ports of a type of node.

use serde_json::{Map, Value as Json, json};

use super::values::{self, bound, key_only, literal, plain};
use crate::descriptor::engine::{EngineType, Shape};
use crate::tree::{Direction, Host, NodeType, PortSpec};

/// Ports by name, and the names of those that have to be bound.
pub(super) struct Ports {
    properties: Map<String, Json>,
    required: Vec<&'static str>,
}

pub(super) fn with_ports(ports: Ports) -> Map<String, Json> {
    let Ports {
        properties,
        required,
    } = ports;
    let mut then = Map::new();
    if !required.is_empty() {
        then.insert("required".to_owned(), json!(["ports"]));
    }
    let ports = json!({
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    });
    then.insert("properties".to_owned(), json!({"ports": ports}));
    then
}

pub(super) fn registered_ports<H: Host>(t: &NodeType<H>) -> Ports {
    let mut properties = Map::new();
    let mut required = Vec::new();
    for port in &t.ports {
        properties.insert(port.name.to_owned(), registered_port(port));
        if port.default.is_none() {
            required.push(port.name);
        }
    }
    Ports {
        properties,
        required,
    }
}

fn registered_port(port: &PortSpec) -> Json {
    let mut schema = match port.direction {
        Direction::Out => key_only(),
        Direction::In => {
            let literal = values::within(port.value_type, port.range, port.choices);
            bound(Some((port.value_type, literal)))
        }
    };
    let doc = format!("{} ({})", port.doc, port.value_type.name());
    values::describe(&mut schema, &doc, port.default.map(values::example));
    schema
}

pub(super) fn engine_ports(t: &EngineType) -> Ports {
    use crate::ValueType::{Bool, Integer, Number, Text};
    let mut properties = Map::new();
    let mut required = Vec::new();
    for port in t.ports {
        let mut schema = match port.shape {
            Shape::Bool => literal(Bool, plain(Bool)),
            Shape::Count(least) => {
                let count = json!({"type": "integer", "minimum": least, "maximum": u32::MAX});
                literal(Integer, count)
            }
            Shape::Choice(words) => literal(Text, json!({"enum": words})),
            Shape::Seconds => bound(Some((Number, json!({"type": "number", "minimum": 0})))),
            Shape::Number => literal(Number, plain(Number)),
            Shape::Value => values::any_literal(),
            Shape::Bound => bound(None),
            Shape::Key => key_only(),
            Shape::Ids => json!({"type": "array", "minItems": 1, "items": {"type": "string"}}),
        };
        let default = port
            .default
            .and_then(|text| serde_json::from_str(text).ok());
        values::describe(&mut schema, port.doc, default);
        properties.insert(port.name.to_owned(), schema);
        if port.required {
            required.push(port.name);
        }
    }
    Ports {
        properties,
        required,
    }
}
