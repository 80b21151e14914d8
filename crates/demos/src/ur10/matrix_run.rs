//! A matrix of events and states at work: what happens in it is told, and its
//! state goes into the policy's record.

use robocell_task::TraceEvent;
use std::sync::Arc;

use behavior::machine::StateId;
use behavior::matrix::{EventId, EventSet, Handlers, Happening, Matrix, Next, StepError, Table};
use behavior::{Graph, NodeStatus};
use ipc_types::Text;
use serde::Serialize;
use serde::de::{DeserializeOwned, Error as _};
use serde_bytes::{ByteBuf, Bytes};

use super::Named;
use robocell_task::checkpoint;
use robocell_task::output::Output;

/// Event of the source that is pending when no other is.
const IDLE: &str = "NONE";

/// The set of those events that are pending.
pub(crate) fn pending<E: Named>(events: &[(E, bool)]) -> EventSet {
    let pending = events.iter().filter(|(_, is_pending)| *is_pending);
    pending.fold(EventSet::EMPTY, |set, (event, _)| {
        set.with(EventId(event.index()))
    })
}

/// A handler's answer: to `state`.
pub(crate) fn goto(state: impl Named) -> Next {
    Next::Goto(StateId(state.index()))
}

/// One matrix, with the table it begins anew from.
#[derive(Clone, Debug)]
pub(crate) struct MatrixRun {
    table: Arc<Table>,
    matrix: Matrix,
    /// State and event of the cell that was shown last: one at work again and
    /// again is worth one line.
    shown: Option<(u16, u16)>,
}

impl MatrixRun {
    /// In its first state.
    pub(crate) fn new(table: Arc<Table>) -> Self {
        Self {
            matrix: Matrix::new(Arc::clone(&table)),
            table,
            shown: None,
        }
    }

    /// Back in its first state.
    pub(crate) fn reset(&mut self) {
        *self = Self::new(Arc::clone(&self.table));
    }

    /// Its state: a file has no others than those of the job's vocabulary.
    pub(crate) fn state<S: Named>(&self) -> Option<S> {
        S::at(self.matrix.state().0)
    }

    /// Puts it into a state without a handler: what is seen leaves no other.
    pub(crate) fn set(&mut self, next: Next) -> bool {
        if let Next::Goto(state) = next {
            self.matrix.set_state(state);
        }
        next != Next::Stay
    }

    /// Name of the state.
    pub(crate) fn phase(&self) -> Text<32> {
        Text::new(self.matrix.state_name())
    }

    /// Handles the first of the pending events.
    ///
    /// # Errors
    /// Where a handler goes where its cell does not lead: the state is what it was.
    pub(crate) fn handle(
        &mut self,
        pending: EventSet,
        handlers: &mut impl Handlers,
    ) -> Result<(), StepError> {
        self.matrix.clear_trace();
        self.matrix.tick(pending, handlers).map(|_| ())
    }

    /// Tells which event was `handled` and which state was left for which. Answers
    /// whether one was.
    pub(crate) fn tell(&mut self, handled: Result<(), StepError>, out: &mut Output) -> bool {
        if let Err(wrong) = handled {
            out.event(TraceEvent::Fault, format_args!("[fault] {wrong}"));
        }
        let mut changed = false;
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
                } if self.table.event_name(event) != IDLE => {
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

    /// Its picture.
    pub(crate) fn describe(&self) -> Vec<Graph> {
        vec![self.matrix.describe()]
    }

    /// Appends how the states stand.
    pub(crate) fn statuses(&self, out: &mut Vec<NodeStatus>) {
        out.extend(self.matrix.statuses());
    }

    /// A policy's record: the state, and what it remembers besides.
    pub(crate) fn save(&self, memory: &impl Serialize) -> Vec<u8> {
        let mut state = Vec::with_capacity(self.matrix.record_bytes());
        self.matrix.save(&mut state);
        checkpoint::to_bytes(&(Bytes::new(&state), self.shown, memory))
    }

    /// Takes the state of such a checkpoint, and answers the rest of it.
    ///
    /// # Errors
    /// For a checkpoint that is damaged, of another matrix, or whose memory is not
    /// `sound`; nothing has changed then.
    pub(crate) fn restore<M: DeserializeOwned>(
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
