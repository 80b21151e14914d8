//! What happened in a tick, for traces.

use crate::board::Fault;
use crate::status::{NodeStatus, ResetReason};

/// Something that happened to a node during the last tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// Index of the node in the graph.
    pub node: usize,
    /// What happened.
    pub kind: EventKind,
}

/// Kinds of [`Event`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EventKind {
    /// Its status, with its modifiers, is another one than after the tick
    /// before. What came and went within the tick is not told.
    Status {
        /// What it was.
        from: NodeStatus,
        /// What it is.
        to: NodeStatus,
        /// Why, if it was stopped.
        reason: Option<ResetReason>,
    },
    /// The answer of its guard or check is another one than before.
    Guard {
        /// The answer.
        holds: bool,
    },
    /// A port could not be used, and the node failed.
    Fault(Fault),
    /// More happened than could be noted; the rest of the tick is missing.
    Overflow,
}

/// Room per node: a status, a guard, a fault, and one that happens twice.
const PER_NODE: usize = 4;
const AT_LEAST: usize = 16;

/// The events of one tick, in memory taken when the tree is made.
pub(super) struct Events {
    list: Vec<Event>,
    room: usize,
}

impl Events {
    pub(super) fn for_nodes(count: usize) -> Self {
        let room = count * PER_NODE + AT_LEAST;
        Self {
            list: Vec::with_capacity(room + 1),
            room,
        }
    }

    #[inline]
    pub(super) fn clear(&mut self) {
        self.list.clear();
    }

    pub(super) fn list(&self) -> &[Event] {
        &self.list
    }

    #[inline]
    pub(super) fn push(&mut self, node: usize, kind: EventKind) {
        if self.list.len() < self.room {
            self.list.push(Event { node, kind });
        } else if self.list.len() == self.room {
            let kind = EventKind::Overflow;
            self.list.push(Event { node, kind });
        }
    }
}
