//! The events of a tick, for traces.

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
    /// Its status, with its modifiers, differs from that after the tick before. Changes that
    /// were reversed within the tick are not reported.
    Status {
        /// The status before.
        from: NodeStatus,
        /// The new status.
        to: NodeStatus,
        /// Why, if it was stopped.
        reason: Option<ResetReason>,
    },
    /// The result of its guard or check differs from the one before.
    Guard {
        /// The answer.
        holds: bool,
    },
    /// A port could not be used, and the node failed.
    Fault(Fault),
    /// More events than there is room for; the rest of the tick is missing.
    Overflow,
}

/// Room per node: a status, a guard, a fault, and one that happens twice.
// Four per node cover a tick in which each kind happens; an `Overflow` reports any more.
const PER_NODE: usize = 4;
// Small trees with several checks per node need room beyond four per node.
const AT_LEAST: usize = 16;

/// The events of one tick, in memory that is allocated when the tree is made.
pub(super) struct Events {
    list: Vec<Event>,
    room: usize,
}

impl Events {
    pub(super) fn for_nodes(count: usize) -> Self {
        let room = count * PER_NODE + AT_LEAST;
        Self {
            // One more for `Overflow`, which must not allocate either.
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
