//! A compiled matrix: flat arrays.

use super::ids::{EventId, EventSet, HandlerId};
use crate::machine::{BehaviorId, Final, StateId};

#[derive(Clone, Debug)]
pub(crate) struct State {
    pub(crate) name: String,
    pub(crate) hash: u64,
    pub(crate) end: Final,
    pub(crate) during: Option<During>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct During {
    pub(crate) run: BehaviorId,
    pub(crate) success: Option<EventId>,
    pub(crate) failure: Option<EventId>,
}

#[derive(Clone, Debug)]
pub(crate) struct Filled {
    pub(crate) handler: HandlerId,
    pub(crate) goto: Vec<StateId>,
}

/// A compiled matrix. Shared by reference among the matrices that run it.
#[derive(Clone, Debug)]
pub struct Table {
    pub(crate) name: String,
    pub(crate) states: Vec<State>,
    pub(crate) initial: StateId,
    pub(crate) events: Vec<String>,
    pub(crate) handlers: Vec<String>,
    pub(crate) behaviors: Vec<String>,
    /// Events, the one with the highest precedence first.
    pub(crate) order: Vec<EventId>,
    pub(crate) idle: Option<EventId>,
    /// Cells of `state * events + event`.
    pub(crate) cells: Vec<Option<Filled>>,
}

impl Table {
    /// Name of the matrix.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The event to handle: the first pending one of the precedence list, or
    /// the idle one, if none is pending and the matrix has one.
    pub fn pick(&self, pending: EventSet) -> Option<EventId> {
        let first = self.order.iter().find(|event| pending.contains(**event));
        first.copied().or(self.idle)
    }

    /// The state with this name.
    pub fn state(&self, name: &str) -> Option<StateId> {
        let found = self.states.iter().position(|state| state.name == name);
        found.map(StateId::of)
    }

    /// Name of a state; empty for one of another matrix.
    pub fn state_name(&self, state: StateId) -> &str {
        self.states.get(state.index()).map_or("", |it| &it.name)
    }

    /// The event with this name.
    pub fn event(&self, name: &str) -> Option<EventId> {
        let found = self.events.iter().position(|event| event == name)?;
        u16::try_from(found).ok().map(EventId)
    }

    /// Name of an event; empty for one of another matrix.
    pub fn event_name(&self, event: EventId) -> &str {
        self.events.get(usize::from(event.0)).map_or("", |it| it)
    }

    /// Name of a handler; empty for one of another vocabulary.
    pub fn handler_name(&self, handler: HandlerId) -> &str {
        self.handlers
            .get(usize::from(handler.0))
            .map_or("", |it| it)
    }

    /// Name of a sub-behaviour; empty for one of another vocabulary.
    pub fn behavior_name(&self, behavior: BehaviorId) -> &str {
        self.behaviors.get(behavior.index()).map_or("", |it| it)
    }

    /// The handler of a cell; none if the cell is not filled in.
    pub fn handler(&self, state: StateId, event: EventId) -> Option<HandlerId> {
        self.cell(state, event).map(|cell| cell.handler)
    }

    pub(crate) fn cell(&self, state: StateId, event: EventId) -> Option<&Filled> {
        let event = usize::from(event.0);
        // An id of another matrix would otherwise find the cell of the next state.
        if event >= self.events.len() {
            return None;
        }
        let at = state.index() * self.events.len() + event;
        self.cells.get(at)?.as_ref()
    }
}
