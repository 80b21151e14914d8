//! The events inside a machine, for the trace.

use super::ids::{BehaviorId, GuardId, RowId, StateId, TriggerId};
use crate::status::Status;

/// Largest number of events kept between two reads; later ones are counted, not kept.
// Allocated once: no memory is requested within a decision.
pub const TRACE_CAPACITY: usize = 128;

/// An event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening {
    /// A guard was evaluated.
    Guard {
        /// The guard.
        guard: GuardId,
        /// Its result.
        value: bool,
    },
    /// A row was taken.
    Transition {
        /// The row.
        row: RowId,
        /// Its trigger.
        trigger: TriggerId,
        /// The state that was left.
        source: StateId,
        /// The state that was entered; none for an internal row.
        dest: Option<StateId>,
    },
    /// A state was left.
    Left(StateId),
    /// A state was entered.
    Entered(StateId),
    /// No active state has a row for the trigger.
    Invalid(TriggerId),
    /// There are rows for the trigger, but no row's guards hold.
    Blocked(TriggerId),
    /// A callback failed.
    Failed(TriggerId),
    /// A sub-behaviour finished.
    Finished {
        /// The sub-behaviour.
        behavior: BehaviorId,
        /// Its result.
        status: Status,
    },
}

/// A bounded list of events, oldest first.
#[derive(Clone, Debug)]
pub(crate) struct Trace<T> {
    kept: Vec<T>,
    lost: u32,
}

impl<T> Trace<T> {
    pub(crate) fn new() -> Self {
        Self {
            kept: Vec::with_capacity(TRACE_CAPACITY),
            lost: 0,
        }
    }

    /// Keeps it if there is room; the list never grows.
    pub(crate) fn add(&mut self, happening: T) {
        // The oldest are kept and not the newest: the cause of a chain of events comes first.
        if self.kept.len() < TRACE_CAPACITY {
            self.kept.push(happening);
        } else {
            self.lost = self.lost.saturating_add(1);
        }
    }

    pub(crate) fn kept(&self) -> &[T] {
        &self.kept
    }

    pub(crate) fn lost(&self) -> u32 {
        self.lost
    }

    pub(crate) fn clear(&mut self) {
        self.kept.clear();
        self.lost = 0;
    }
}
