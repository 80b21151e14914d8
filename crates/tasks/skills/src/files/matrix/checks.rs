//! Mistakes in a matrix that are refused when its file is loaded.

use behavior::inline::Inline;
use behavior::machine::{Final, StateId};
use behavior::matrix::{Definition, EventId, Table};
use behavior::suggest;

/// The event with this name.
pub(super) fn event_named(
    definition: &Definition,
    table: &Table,
    name: &str,
) -> Result<EventId, String> {
    table.event(name).ok_or_else(|| {
        let known: Vec<&str> = definition
            .precedence
            .iter()
            .map(|event| event.text.as_str())
            .collect();
        let (file, advice) = (&definition.file, suggest::advice(name, &known));
        format!("{file}: event '{name}' is not in the precedence list; {advice}")
    })
}

/// Refuses a state that a run would never leave: the job would wait there until its time limit.
pub(super) fn refuse_dead_ends(
    definition: &Definition,
    table: &Table,
    ends: &[StateId],
) -> Result<(), String> {
    for state in &definition.states {
        let id = table.state(&state.name.text);
        let mut events = definition.precedence.iter();
        let answers = events.any(|event| {
            let event = table.event(&event.text);
            id.zip(event)
                .is_some_and(|(id, event)| table.handler(id, event).is_some())
        });
        let gives_up = id.is_some_and(|id| ends.contains(&id));
        if state.end == Final::No && !answers && !gives_up {
            let (file, place) = (&definition.file, state.name.place);
            return Err(format!(
                "{file}:{}:{}: state '{}' answers no event; give it a cell, final = true, or \
                 FailJob as its last step",
                place.line, place.column, state.name.text
            ));
        }
    }
    Ok(())
}

/// Refuses an event that is never raised: its cells would have no effect.
pub(super) fn refuse_silent_events(definition: &Definition, inline: &Inline) -> Result<(), String> {
    let mut raised: Vec<&str> = inline
        .events
        .iter()
        .map(|part| part.name.as_str())
        .collect();
    for handler in &inline.handlers {
        raised.extend(
            handler
                .success
                .iter()
                .chain(&handler.failure)
                .map(String::as_str),
        );
    }
    for during in definition.states.iter().filter_map(|s| s.during.as_ref()) {
        let results = during.success.iter().chain(&during.failure);
        raised.extend(results.map(|name| name.text.as_str()));
    }
    // The idle event is raised by the engine itself.
    raised.extend(definition.idle.iter().map(|name| name.text.as_str()));
    for event in &definition.precedence {
        if !raised.contains(&event.text.as_str()) {
            let (file, place) = (&definition.file, event.place);
            return Err(format!(
                "{file}:{}:{}: nothing raises event '{}'; give it a condition in [events], or \
                 name it as the success or failure of a handler",
                place.line, place.column, event.text
            ));
        }
    }
    Ok(())
}
