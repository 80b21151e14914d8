//! A machine case: events are fired and the results compared with the reference.

use std::sync::Arc;

use behavior::machine::{
    Actions, CallbackId, Definition, Event, Fault, GuardId, Machine, Name, StateDef, Table,
    TriggerError, Vocabulary,
};
use serde_json::{Value, json};

const MACHINE_CALLBACKS: [&str; 4] = [
    "prepare_event",
    "before_state_change",
    "after_state_change",
    "finalize_event",
];

/// Runs one case; a difference is the error.
pub(crate) fn run(case: &Value) -> Result<(), String> {
    let (table, callbacks) = load(case)?;
    let guards = guard_names(case);
    let mut machine = Machine::new(Arc::new(table));
    let events = list(case, "events")?.iter().zip(list(case, "expect")?);
    for (number, (event, expected)) in events.enumerate() {
        let answers = guards
            .iter()
            .map(|guard| event.pointer(&format!("/guards/{guard}")) == Some(&Value::Bool(true)));
        let mut host = Host {
            answers: answers.collect(),
            callbacks: &callbacks,
            log: Vec::new(),
        };
        let got = fire(&mut machine, event, &mut host)?;
        if got != *expected {
            return Err(format!("event {number}: expected {expected}, got {got}"));
        }
    }
    Ok(())
}

struct Host<'a> {
    answers: Vec<bool>,
    callbacks: &'a [String],
    log: Vec<Value>,
}

impl Actions for Host<'_> {
    fn guard(&mut self, guard: GuardId) -> bool {
        self.answers.get(guard.index()) == Some(&true)
    }

    fn call(&mut self, callback: CallbackId, _: &mut Event<'_>) -> Result<(), Fault> {
        let name = self.callbacks.get(callback.index()).cloned();
        self.log.push(name.into());
        Ok(())
    }
}

fn fire(machine: &mut Machine, event: &Value, host: &mut Host<'_>) -> Result<Value, String> {
    let name = text(event, "trigger")?;
    let trigger = machine.table().trigger(name);
    let trigger = trigger.ok_or_else(|| format!("no trigger '{name}'"))?;
    let may = machine.may(trigger, host);
    let result = match machine.trigger(trigger, host) {
        Ok(fired) => json!(fired.taken),
        Err(TriggerError::Invalid { .. }) => json!("invalid"),
        Err(other) => return Err(other.to_string()),
    };
    let log = std::mem::take(&mut host.log);
    Ok(json!({"result": result, "state": machine.state_name(), "may": may, "log": log}))
}

/// The machine in our format, and its callbacks.
fn load(case: &Value) -> Result<(Table, Vec<String>), String> {
    let states: Vec<&str> = list(case, "states")?
        .iter()
        .filter_map(Value::as_str)
        .collect();
    let mut callbacks: Vec<String> = MACHINE_CALLBACKS.map(str::to_owned).to_vec();
    for state in &states {
        callbacks.extend([format!("enter_{state}"), format!("exit_{state}")]);
    }
    for row in 0..list(case, "rows")?.len() {
        callbacks
            .extend(["prepare", "before", "after"].map(|moment| format!("row_{row}_{moment}")));
    }
    let file = json!({
        "version": 1, "name": "case",
        "states": states, "initial": case.get("initial"), "rows": case.get("rows"),
    });
    let read = Definition::read("case.json", &file.to_string());
    let mut definition = read.map_err(|wrong| wrong.to_string())?;
    definition.states = states.iter().map(|name| with_callbacks(name)).collect();
    let one = |name: &str| vec![Name::from(name)];
    definition.prepare_event = one("prepare_event");
    definition.before_state_change = one("before_state_change");
    definition.after_state_change = one("after_state_change");
    definition.finalize_event = one("finalize_event");
    let guards = guard_names(case);
    let guards: Vec<&str> = guards.iter().map(String::as_str).collect();
    let known: Vec<&str> = callbacks.iter().map(String::as_str).collect();
    let vocabulary = Vocabulary {
        guards: &guards,
        callbacks: &known,
        ..Vocabulary::default()
    };
    let table = definition
        .compile(&vocabulary)
        .map_err(|wrong| wrong.to_string())?;
    Ok((table, callbacks))
}

fn with_callbacks(state: &str) -> StateDef {
    let (enter, exit) = (format!("enter_{state}"), format!("exit_{state}"));
    StateDef::new(state).enter(&[&enter]).exit(&[&exit])
}

/// Guards, as the first event lists them.
fn guard_names(case: &Value) -> Vec<String> {
    let first = case.pointer("/events/0/guards").and_then(Value::as_object);
    first
        .map(|guards| guards.keys().cloned().collect())
        .unwrap_or_default()
}

fn list<'a>(case: &'a Value, key: &str) -> Result<&'a Vec<Value>, String> {
    let found = case.get(key).and_then(Value::as_array);
    found.ok_or_else(|| format!("the case has no list '{key}'"))
}

fn text<'a>(value: &'a Value, key: &str) -> Result<&'a str, String> {
    let found = value.get(key).and_then(Value::as_str);
    found.ok_or_else(|| format!("no text '{key}'"))
}
