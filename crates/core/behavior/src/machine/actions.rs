//! The interface between a machine and its host.

use super::ids::{BehaviorId, CallbackId, GuardId, RowId, StateId, TriggerId};
use crate::status::{ResetReason, Status};

/// Number of triggers that can wait while one is handled.
// A call is bounded: a callback that posts without end fails instead of filling memory.
pub const QUEUE_CAPACITY: usize = 16;

/// Why a callback could not do its work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{reason}")]
pub struct Fault {
    /// For people.
    pub reason: &'static str,
}

/// The queue is full.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("more than {QUEUE_CAPACITY} triggers wait; handle some before posting more")]
pub struct QueueFull;

impl From<QueueFull> for Fault {
    fn from(_: QueueFull) -> Self {
        Self {
            reason: "more triggers posted than can wait",
        }
    }
}

/// Guards, callbacks and sub-behaviours of a host, by their place in its
/// [`Vocabulary`](super::Vocabulary).
pub trait Actions {
    /// Whether a guard holds. Evaluated at most once for each trigger.
    fn guard(&mut self, guard: GuardId) -> bool;

    /// Runs a callback.
    ///
    /// # Errors
    /// A [`Fault`] ends the handling of this trigger; see
    /// [`Machine::trigger`](super::Machine::trigger) for the state it leaves.
    fn call(&mut self, callback: CallbackId, event: &mut Event<'_>) -> Result<(), Fault>;

    /// Ticks the sub-behaviour of an active state. Never called for a machine whose file names
    /// none.
    fn run(&mut self, behavior: BehaviorId) -> Status {
        let _ = behavior;
        Status::Running
    }

    /// Stops a sub-behaviour whose state was left before it finished. Returns whether it has
    /// stopped; until it has, this is called again on every
    /// [`Machine::tick`](super::Machine::tick).
    fn halt(&mut self, behavior: BehaviorId, reason: ResetReason) -> bool {
        let _ = (behavior, reason);
        true
    }
}

/// The context and the actions of a callback.
#[derive(Debug)]
pub struct Event<'a> {
    /// The trigger that is being handled.
    pub trigger: TriggerId,
    /// Row that is tried or taken; none in the machine's own callbacks before
    /// and after all rows.
    pub row: Option<RowId>,
    /// State the row leaves from.
    pub source: Option<StateId>,
    /// State it leads to; none for an internal row.
    pub dest: Option<StateId>,
    pub(super) queue: &'a mut Queue,
}

impl Event<'_> {
    /// Handles `trigger` after this one.
    ///
    /// # Errors
    /// When [`QUEUE_CAPACITY`] triggers wait.
    pub fn post(&mut self, trigger: TriggerId) -> Result<(), QueueFull> {
        // Queued, never handled at once: a nested change in an exit callback would enter a
        // state while another one is half left.
        self.queue.push(trigger)
    }
}

/// Triggers that wait, first in, first out.
#[derive(Clone, Debug)]
pub(super) struct Queue {
    waiting: [TriggerId; QUEUE_CAPACITY],
    first: usize,
    len: usize,
}

impl Queue {
    pub(super) const EMPTY: Self = Self {
        waiting: [TriggerId(0); QUEUE_CAPACITY],
        first: 0,
        len: 0,
    };

    pub(super) fn push(&mut self, trigger: TriggerId) -> Result<(), QueueFull> {
        if self.len == QUEUE_CAPACITY {
            return Err(QueueFull);
        }
        let at = (self.first + self.len) % QUEUE_CAPACITY;
        *self.waiting.get_mut(at).ok_or(QueueFull)? = trigger;
        self.len += 1;
        Ok(())
    }

    pub(super) fn pop(&mut self) -> Option<TriggerId> {
        if self.len == 0 {
            return None;
        }
        let trigger = self.waiting.get(self.first).copied();
        self.first = (self.first + 1) % QUEUE_CAPACITY;
        self.len -= 1;
        trigger
    }

    pub(super) fn clear(&mut self) {
        self.len = 0;
    }
}
