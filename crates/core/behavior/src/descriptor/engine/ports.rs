//! Ports that several types have.

use super::{EnginePort, Shape, port};

pub(super) const fn memory(default: &'static str) -> EnginePort {
    port(
        "memory",
        Shape::Bool,
        Some(default),
        false,
        "true: continues with the child that was running; false: asks its children from the first one again at every tick",
    )
}

pub(super) const SECONDS: EnginePort =
    port("seconds", Shape::Seconds, None, true, "Seconds, 0 or more");

pub(super) const AT_ONCE: EnginePort = port(
    "at_once",
    Shape::Bool,
    Some("false"),
    false,
    "true: when a child that was running ends, the next run starts in the same tick",
);

pub(super) const KEY: EnginePort = port("key", Shape::Key, None, true, "The blackboard key");

pub(super) const TEST: &[EnginePort] = &[
    KEY,
    port(
        "equals",
        Shape::Value,
        None,
        false,
        "Holds where the key has this value",
    ),
    port(
        "differs",
        Shape::Value,
        None,
        false,
        "Holds where the key has another value or none",
    ),
    port(
        "below",
        Shape::Number,
        None,
        false,
        "Holds where the key is a number below this one",
    ),
    port(
        "above",
        Shape::Number,
        None,
        false,
        "Holds where the key is a number above this one",
    ),
    port(
        "set",
        Shape::Bool,
        None,
        false,
        "true: holds where the key has a value; false: where it has none",
    ),
];
