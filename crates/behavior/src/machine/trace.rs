//! What happened inside, for the trace.

use super::ids::{BehaviorId, GuardId, RowId, StateId, TriggerId};
use crate::status::Status;

/// Most happenings kept between two drains; later ones are counted, not kept.
pub const TRACE_CAPACITY: usize = 128;

/// One thing that happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening {
    /// A guard was asked.
    Guard {
        /// Which.
        guard: GuardId,
        /// Its answer.
        value: bool,
    },
    /// A row was taken.
    Transition {
        /// Which.
        row: RowId,
        /// On what.
        trigger: TriggerId,
        /// From where.
        source: StateId,
        /// To where; none for an internal row.
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
        /// Which.
        behavior: BehaviorId,
        /// How.
        status: Status,
    },
}

/// A bounded list of happenings, oldest first.
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

    /// Keeps it if there is room: never grows.
    pub(crate) fn add(&mut self, happening: T) {
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
