//! A running matrix of events and states. Its changes are traced, and its state is part of the
//! policy's checkpoint.

use std::sync::Arc;

use behavior::machine::StateId;
use behavior::matrix::{EventId, EventSet, Handlers, Happening, Matrix, Next, StepError, Table};
use behavior::{Graph, NodeStatus, Status};
use ipc_types::Text;
use robocell_task::{Output, TraceEvent, checkpoint};
use serde::Serialize;
use serde::de::{DeserializeOwned, Error as _};
use serde_bytes::{ByteBuf, Bytes};

use crate::named::Named;

/// A handler's result: the transition to `state`.
pub fn goto(state: impl Named) -> Next {
    Next::Goto(StateId(state.index()))
}

/// A matrix, with its table for a reset.
#[derive(Clone, Debug)]
pub struct MatrixRun {
    table: Arc<Table>,
    matrix: Matrix,
    /// State and event of the last traced cell: one that is handled in every decision is traced
    /// once.
    shown: Option<(u16, u16)>,
}

impl MatrixRun {
    /// A matrix in its first state.
    pub fn new(table: Arc<Table>) -> Self {
        Self {
            matrix: Matrix::new(Arc::clone(&table)),
            table,
            shown: None,
        }
    }

    /// Resets the matrix to its first state.
    pub fn reset(&mut self) {
        *self = Self::new(Arc::clone(&self.table));
    }

    /// Its table.
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Its state, by index.
    pub fn state_id(&self) -> StateId {
        self.matrix.state()
    }

    /// Whether a final state was reached.
    pub fn status(&self) -> Status {
        self.matrix.status()
    }

    /// Its state. A file has no other states than those of the job's vocabulary.
    pub fn state<S: Named>(&self) -> Option<S> {
        S::at(self.matrix.state().0)
    }

    /// Changes its state without a handler. Returns whether `next` is a transition.
    pub fn set(&mut self, next: Next) -> bool {
        if let Next::Goto(state) = next {
            self.matrix.set_state(state);
        }
        next != Next::Stay
    }

    /// Name of the state.
    pub fn phase(&self) -> Text<32> {
        Text::new(self.matrix.state_name())
    }

    /// Handles the first of the pending events.
    ///
    /// # Errors
    /// Returns an error if a handler chooses a transition that its cell does not have; the
    /// state is unchanged then.
    pub fn handle(
        &mut self,
        pending: EventSet,
        handlers: &mut impl Handlers,
    ) -> Result<(), StepError> {
        self.matrix.clear_trace();
        self.matrix.tick(pending, handlers).map(|_| ())
    }

    /// Traces the handled event and the transition. Returns whether the state changed.
    pub fn tell(&mut self, handled: Result<(), StepError>, out: &mut Output) -> bool {
        if let Err(wrong) = handled {
            out.event(TraceEvent::Fault, format_args!("[fault] {wrong}"));
        }
        let mut changed = false;
        let idle = self.table.pick(EventSet::EMPTY);
        for happening in self.matrix.trace() {
            match *happening {
                Happening::Changed { from, to, event } => {
                    self.tell_change(from, to, event, out);
                    changed = true;
                }
                Happening::Handled {
                    state,
                    event,
                    handler: Some(_),
                    // The idle event is handled in nearly every decision and would fill the
                    // trace.
                } if Some(event) != idle => {
                    let shown = Some((state.0, event.0));
                    if self.shown != shown {
                        self.shown = shown;
                        let name = self.table.event_name(event);
                        out.guard((0, state.index()), name, true);
                    }
                }
                _ => {}
            }
        }
        crate::machine_run::lost(self.matrix.lost_happenings(), out);
        changed
    }

    fn tell_change(&self, from: StateId, to: StateId, event: EventId, out: &mut Output) {
        let event = self.table.event_name(event);
        let node = |state: StateId| (0, state.index());
        out.status(node(from), NodeStatus::Running, NodeStatus::Invalid, event);
        out.status(node(to), NodeStatus::Invalid, NodeStatus::Running, event);
        let (from, to) = (self.table.state_name(from), self.table.state_name(to));
        out.transition(format_args!("{from} -> {to} ({event})"));
    }

    /// Its graph.
    pub fn describe(&self) -> Vec<Graph> {
        vec![self.matrix.describe()]
    }

    /// Appends the statuses of its states.
    pub fn statuses(&self, out: &mut Vec<NodeStatus>) {
        out.extend(self.matrix.statuses());
    }

    /// The record of a policy: the state, and its other memory.
    pub fn save(&self, memory: &impl Serialize) -> Vec<u8> {
        let mut state = Vec::with_capacity(self.matrix.record_bytes());
        self.matrix.save(&mut state);
        checkpoint::to_bytes(&(Bytes::new(&state), self.shown, memory))
    }

    /// Restores the state of such a record, and returns the other memory.
    ///
    /// # Errors
    /// Returns an error for a record that is damaged, of another matrix, or whose memory is not
    /// `sound`; nothing has changed then.
    pub fn restore<M: DeserializeOwned>(
        &mut self,
        bytes: &[u8],
        sound: impl FnOnce(&M) -> bool,
    ) -> Result<M, bincode::Error> {
        let (state, shown, memory): (ByteBuf, _, M) = checkpoint::from_bytes(bytes)?;
        if !sound(&memory) {
            return Err(bincode::Error::custom("no job of this cell remembers that"));
        }
        self.matrix
            .restore(&state)
            .map_err(bincode::Error::custom)?;
        self.shown = shown;
        Ok(memory)
    }
}
