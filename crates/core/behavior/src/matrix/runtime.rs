//! A running matrix.
//!
//! One event is handled per tick: that with the highest precedence, so a broken grip wins over
//! a reached goal, in every state alike. A handler can only change to a state that its cell
//! declares; the checks of unreachable states and dead ends rely on it.

use std::sync::Arc;

use super::ids::{EventId, EventSet, HandlerId};
use super::table::{During, Table};
use crate::machine::record::{entries, write};
use crate::machine::set::SmallSet;
use crate::machine::trace::Trace;
use crate::machine::{BehaviorId, Fault, Final, RestoreError, StateId};
use crate::status::{NodeStatus, ResetReason, Status};

// The same flags as in records of machines, with which this format is shared.
const ACTIVE: u8 = 1;
const RUNNING: u8 = 2;
const FINISHED: u8 = 4;
const HALTING: u8 = 8;

/// The context of a handler.
#[derive(Clone, Copy, Debug)]
pub struct Cell<'a> {
    /// State of the cell.
    pub state: StateId,
    /// Event of the cell.
    pub event: EventId,
    /// States to which the cell may change.
    pub goto: &'a [StateId],
}

/// The decision of a handler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Next {
    /// The state stays the same.
    Stay,
    /// The new state; the cell must declare it.
    Goto(StateId),
}

/// Handlers and sub-behaviours of a host.
pub trait Handlers {
    /// Handles an event in a state.
    ///
    /// # Errors
    /// A [`Fault`] leaves the state as it is.
    fn handle(&mut self, handler: HandlerId, cell: Cell<'_>) -> Result<Next, Fault>;

    /// Ticks the sub-behaviour of the active state.
    fn run(&mut self, behavior: BehaviorId) -> Status {
        let _ = behavior;
        Status::Running
    }

    /// Stops a sub-behaviour whose state was left before it finished. Returns whether it has
    /// stopped; until it has, this is called again on every
    /// [`Matrix::tick`].
    fn halt(&mut self, behavior: BehaviorId, reason: ResetReason) -> bool {
        let _ = (behavior, reason);
        true
    }
}

/// Why an event was not handled. The state is unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StepError {
    /// The handler failed.
    #[error("the handler of {event:?} in {state:?} failed: {fault}")]
    Failed {
        /// State of the cell.
        state: StateId,
        /// Event of the cell.
        event: EventId,
        /// The error of the handler.
        fault: Fault,
    },
    /// The handler changes to a state that its cell does not declare.
    #[error(
        "the handler of {event:?} in {state:?} goes to {to:?}, which its cell does not declare; add it to goto"
    )]
    Undeclared {
        /// State of the cell.
        state: StateId,
        /// Event of the cell.
        event: EventId,
        /// The state to which it changes.
        to: StateId,
    },
}

/// An event in the trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening {
    /// An event was handled; without a handler it had no effect.
    Handled {
        /// The state.
        state: StateId,
        /// The event.
        event: EventId,
        /// The handler, if the cell is filled in.
        handler: Option<HandlerId>,
    },
    /// The state changed.
    Changed {
        /// The state that was left.
        from: StateId,
        /// The state that was entered.
        to: StateId,
        /// The event.
        event: EventId,
    },
    /// The handler failed, or changed to a state that its cell does not declare.
    Failed {
        /// The state.
        state: StateId,
        /// The event.
        event: EventId,
    },
    /// A sub-behaviour finished.
    Finished {
        /// The sub-behaviour.
        behavior: BehaviorId,
        /// Its result.
        status: Status,
    },
}

/// A matrix and its active state.
#[derive(Clone, Debug)]
pub struct Matrix {
    table: Arc<Table>,
    state: StateId,
    running: bool,
    finished: bool,
    halting: SmallSet,
    trace: Trace<Happening>,
}

impl Matrix {
    /// A matrix in its initial state.
    pub fn new(table: Arc<Table>) -> Self {
        Self {
            state: table.initial,
            running: false,
            finished: false,
            halting: SmallSet::default(),
            trace: Trace::new(),
            table,
        }
    }

    /// Its table.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// The active state.
    pub fn state(&self) -> StateId {
        self.state
    }

    /// Its name.
    pub fn state_name(&self) -> &str {
        self.table.state_name(self.state)
    }

    /// Sets the state, without any handler. A sub-behaviour is not
    /// stopped, only its status is cleared.
    pub fn set_state(&mut self, state: StateId) {
        if state.index() < self.table.states.len() {
            self.state = state;
            (self.running, self.finished) = (false, false);
        }
    }

    /// Success in a final state, running otherwise.
    pub fn status(&self) -> Status {
        let state = self.table.states.get(self.state.index());
        match state.map(|it| it.end) {
            Some(Final::Success) => Status::Success,
            Some(Final::Failure) => Status::Failure,
            Some(Final::No) | None => Status::Running,
        }
    }

    /// The status of each state, in the order of [`Matrix::describe`].
    pub fn statuses(&self) -> impl Iterator<Item = NodeStatus> {
        (0..self.table.states.len()).map(|at| match at {
            at if at == self.state.index() => self.status().into(),
            at if self.halting.contains(at) => NodeStatus::Halting,
            _ => NodeStatus::Invalid,
        })
    }

    /// The events since [`Matrix::clear_trace`], oldest first.
    pub fn trace(&self) -> &[Happening] {
        self.trace.kept()
    }

    /// Number of events that were not kept.
    pub fn lost_happenings(&self) -> u32 {
        self.trace.lost()
    }

    /// Clears the events.
    pub fn clear_trace(&mut self) {
        self.trace.clear();
    }

    /// Handles one event. A cell that is not filled in has no effect. A change to
    /// the active state has no effect either.
    ///
    /// # Errors
    /// When the handler fails, or changes to a state that its cell does not declare.
    pub fn step(
        &mut self,
        event: EventId,
        handlers: &mut impl Handlers,
    ) -> Result<Next, StepError> {
        let table = Arc::clone(&self.table);
        let state = self.state;
        let cell = table.cell(state, event);
        self.trace.add(Happening::Handled {
            state,
            event,
            handler: cell.map(|cell| cell.handler),
        });
        // Traced before: an event without an effect is visible, too.
        let Some(filled) = cell else {
            return Ok(Next::Stay);
        };
        let goto = &filled.goto;
        let next = handlers.handle(filled.handler, Cell { state, event, goto });
        let wrong = match next {
            // Not a change: its sub-behaviour continues, and no cell has to declare it.
            Ok(Next::Goto(to)) if to == state => return Ok(Next::Stay),
            Ok(Next::Goto(to)) if goto.contains(&to) => {
                self.go(to, event, handlers);
                return Ok(Next::Goto(to));
            }
            Ok(Next::Stay) => return Ok(Next::Stay),
            Ok(Next::Goto(to)) => StepError::Undeclared { state, event, to },
            Err(fault) => StepError::Failed {
                state,
                event,
                fault,
            },
        };
        self.trace.add(Happening::Failed { state, event });
        Err(wrong)
    }

    fn go(&mut self, to: StateId, event: EventId, handlers: &mut impl Handlers) {
        let from = self.state;
        // The sub-behaviour of the old state stops first, while it is still the active one.
        if let Some(during) = self.during().filter(|_| self.running)
            && !handlers.halt(during.run, ResetReason::Aborted)
        {
            self.halting.insert(from.index());
        }
        self.state = to;
        (self.running, self.finished) = (false, false);
        self.trace.add(Happening::Changed { from, to, event });
    }

    fn during(&self) -> Option<During> {
        self.table.states.get(self.state.index())?.during
    }

    /// Ticks the sub-behaviour of the state, adds the event of its result to
    /// the pending ones, and handles the one with the highest precedence. Returns the event
    /// that was handled.
    ///
    /// # Errors
    /// As [`Matrix::step`].
    pub fn tick(
        &mut self,
        pending: EventSet,
        handlers: &mut impl Handlers,
    ) -> Result<Option<EventId>, StepError> {
        // First those that are still stopping; a state does not run one before it has stopped.
        for at in self.halting.iter() {
            let during = self.table.states.get(at).and_then(|it| it.during);
            if during.is_none_or(|during| handlers.halt(during.run, ResetReason::Aborted)) {
                self.halting.remove(at);
            }
        }
        // Before the event is chosen: a result competes with the other events of this tick.
        let pending = self
            .run(handlers)
            .map_or(pending, |event| pending.with(event));
        let Some(event) = self.table.pick(pending) else {
            return Ok(None);
        };
        self.step(event, handlers).map(|_| Some(event))
    }

    /// The event of a sub-behaviour that has finished in this tick.
    fn run(&mut self, handlers: &mut impl Handlers) -> Option<EventId> {
        let during = self.during()?;
        if self.finished || self.halting.contains(self.state.index()) {
            return None;
        }
        let status = handlers.run(during.run);
        self.running = status == Status::Running;
        self.finished = !self.running;
        if self.finished {
            self.trace.add(Happening::Finished {
                behavior: during.run,
                status,
            });
        }
        match status {
            Status::Running => None,
            Status::Success => during.success,
            Status::Failure => during.failure,
        }
    }

    /// Largest number of bytes that [`Matrix::save`] appends.
    pub fn record_bytes(&self) -> usize {
        // Four bytes of header, then a hash of eight bytes and a flag for each state.
        4 + 9 * self.table.states.len()
    }

    /// Appends the whole state to `out`, by names.
    pub fn save(&self, out: &mut Vec<u8>) {
        let flag = |set: bool, flag: u8| if set { flag } else { 0 };
        let states = self.table.states.iter().enumerate();
        let flagged = states.filter_map(|(at, it)| {
            let active = at == self.state.index();
            let flags = flag(active, ACTIVE)
                | flag(active && self.running, RUNNING)
                | flag(active && self.finished, FINISHED)
                | flag(self.halting.contains(at), HALTING);
            (flags != 0).then_some((it.hash, flags))
        });
        write(flagged, out);
    }

    /// Restores a state that was saved, perhaps with an older version of the
    /// file: states are found by name.
    ///
    /// # Errors
    /// When the bytes are not a checkpoint, or the state no longer exists.
    /// The matrix is unchanged then.
    pub fn restore(&mut self, bytes: &[u8]) -> Result<(), RestoreError> {
        let (mut active, mut halting) = (None, SmallSet::default());
        for (hash, flags) in entries(bytes)? {
            let found = self.table.states.iter().position(|it| it.hash == hash);
            let Some(at) = found else { continue };
            if flags & ACTIVE != 0 {
                active = Some((at, flags));
            }
            if flags & HALTING != 0 {
                halting.insert(at);
            }
        }
        // Before the first assignment: on an error the matrix is unchanged.
        let (at, flags) = active.ok_or(RestoreError::Unknown)?;
        self.state = StateId::of(at);
        // The state may have lost its sub-behaviour in the edited file.
        self.running = flags & RUNNING != 0 && self.during().is_some();
        self.finished = flags & FINISHED != 0;
        self.halting = halting;
        Ok(())
    }
}
