//! The JSON Schema of machines and matrices, for editors of JSON and TOML.

use serde_json::{Value, json};

/// Schema of a file with a machine, or, if it has a `precedence` list, with a matrix.
pub fn schema() -> Value {
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "State machine or event x state matrix",
        // The same rule by which files are read, so that editor and program agree on the kind.
        "if": {"required": ["precedence"]},
        "then": matrix(),
        "else": machine(),
        "$defs": {
            "names": {
                "description": "One name, or several.",
                "oneOf": [
                    {"type": "string"},
                    {"type": "array", "items": {"type": "string"}}
                ]
            },
            "final": {
                "description": "Whether the state is an end, and of which kind.",
                "enum": [true, false, "success", "failure"]
            },
            "during": {
                "description": "Behaviour that runs while the state is active, and the triggers of its results.",
                "oneOf": [{"type": "string"}, object(&[], json!({
                    "run": {"type": "string", "description": "A behaviour by its name."},
                    "steps": {"$ref": "#/$defs/steps"},
                    "success": {"type": "string"},
                    "failure": {"type": "string"}
                }))]
            },
            "steps": {
                "description": "Steps, one after the other.",
                "type": "array",
                "items": {"$ref": "#/$defs/step"}
            },
            // Node types depend on the task program; only the shape of a step is known here.
            "step": {
                "description": "Node type and its ports, as in a tree of the same task program.",
                "type": "object",
                "required": ["do"],
                "properties": {
                    "do": {"type": "string"},
                    "not": {"type": "boolean", "description": "Turns the answer round."},
                    "children": {"$ref": "#/$defs/steps"}
                }
            },
            "conditions": {
                "description": "By name: the condition.",
                "type": "object",
                "additionalProperties": {"$ref": "#/$defs/step"}
            },
            "state": state(),
            "row": row(),
            "ordered": ordered()
        }
    })
}

#[allow(
    clippy::needless_pass_by_value,
    reason = "a literal is written where it is called"
)]
fn object(required: &[&str], properties: Value) -> Value {
    json!({
        "type": "object",
        "required": required,
        // A misspelt key is an error in the reader, and is marked in the editor as well.
        "additionalProperties": false,
        "properties": properties
    })
}

fn names(description: &str) -> Value {
    json!({"$ref": "#/$defs/names", "description": description})
}

fn list_of(definition: &str, description: &str) -> Value {
    let item = format!("#/$defs/{definition}");
    json!({"type": "array", "items": {"$ref": item}, "description": description})
}

fn machine() -> Value {
    object(
        &["version", "name", "states", "initial"],
        json!({
            "version": {"const": 1},
            "name": {"type": "string"},
            "doc": {"type": "string"},
            "states": list_of("state", "States; those of a parent are in it."),
            "initial": {"type": "string", "description": "Initial state, by its full name."},
            "triggers": names("Triggers that rows may name; every one they name where missing."),
            "rows": list_of("row", "The first row that fits is taken."),
            "ordered": list_of("ordered", "Chains of states behind one trigger."),
            "prepare_event": names("Run before a trigger is handled."),
            "before_state_change": names("Run when the guards of a row hold."),
            "after_state_change": names("Run after a row's own `after`."),
            "finalize_event": names("Run at the end of every trigger."),
            "on_final": names("Run when the machine has become final."),
            "auto_transitions": {"type": "boolean", "default": false},
            "ignore_invalid_triggers": {"type": "boolean", "default": false},
            "conditions": {"$ref": "#/$defs/conditions"},
            "events": {"$ref": "#/$defs/conditions"},
            "numbers": numbers("Numbers that the host's code works with, by their names."),
            "precision": numbers("By state: when its goal counts as reached.")
        }),
    )
}

fn numbers(description: &str) -> Value {
    json!({"type": "object", "description": description})
}

fn state() -> Value {
    let table = object(
        &["name"],
        json!({
            "name": {"type": "string"},
            "enter": names("Callbacks run on entering."),
            "exit": names("Callbacks run on leaving."),
            "initial": {"type": "string", "description": "Child entered with it."},
            "children": list_of("state", "States inside."),
            "parallel": {"type": "boolean", "default": false},
            "final": {"$ref": "#/$defs/final"},
            "during": {"$ref": "#/$defs/during"}
        }),
    );
    json!({"oneOf": [{"type": "string"}, table]})
}

fn row() -> Value {
    object(
        &["trigger", "source"],
        json!({
            "trigger": {"type": "string"},
            "source": names("States it leaves from; `*` for all."),
            "dest": {
                "type": ["string", "null"],
                "description": "Where it leads; `=` leaves and enters the source; none: internal."
            },
            "internal": {"type": "boolean", "default": false},
            "conditions": names("Guards that must hold."),
            "unless": names("Guards that must not hold."),
            "prepare": names("Callbacks before the guards are asked."),
            "before": names("Callbacks before the state is left."),
            "after": names("Callbacks after the state was entered.")
        }),
    )
}

fn ordered() -> Value {
    object(
        &["trigger"],
        json!({
            "trigger": {"type": "string"},
            "states": names("In their order; all of the outermost level where missing."),
            "loop": {"type": "boolean", "default": true},
            "conditions": names("Guards that must hold for each step."),
            "unless": names("Guards that must not hold.")
        }),
    )
}

fn matrix() -> Value {
    let cell = json!({"oneOf": [{"type": "string"}, object(&["handler"], json!({
        "handler": {"type": "string"},
        "goto": names("States the handler may go to.")
    }))]});
    let cells = json!({"type": "object", "additionalProperties": cell});
    let mut every = cells.clone();
    if let Some(every) = every.as_object_mut() {
        let what = "Handler in states that have no cell for the event.";
        every.insert("description".to_owned(), json!(what));
    }
    let state = json!({"oneOf": [{"type": "string"}, object(&["name"], json!({
        "name": {"type": "string"},
        "final": {"type": "boolean", "default": false},
        "during": {"$ref": "#/$defs/during"}
    }))]});
    object(
        &["version", "name", "precedence", "states", "initial"],
        json!({
            "version": {"const": 1},
            "name": {"type": "string"},
            "doc": {"type": "string"},
            "precedence": names("All events, the most urgent one first."),
            "idle": {"type": "string", "description": "Event that is handled when none is pending."},
            "states": {"type": "array", "items": state},
            "initial": {"type": "string"},
            "cells": {
                "type": "object",
                "description": "By state: the handler of an event.",
                "additionalProperties": cells
            },
            "every": every,
            "events": {"$ref": "#/$defs/conditions"},
            "numbers": numbers("Numbers that the host's code works with, by their names."),
            "precision": numbers("By state: when its goal counts as reached."),
            "handlers": {
                "description": "By name: the steps a handler starts.",
                "type": "object",
                "additionalProperties": object(&["steps"], json!({
                    "steps": {"$ref": "#/$defs/steps"},
                    "success": {"type": "string", "description": "Event once all succeeded."},
                    "failure": {"type": "string", "description": "Event once one failed."}
                }))
            }
        }),
    )
}
