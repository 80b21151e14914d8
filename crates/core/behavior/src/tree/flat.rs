//! A tree as it runs: one flat array in depth-first order.
//!
//! The children of operation `i` start at `i + 1`; the one after the child at `c` is at
//! the `end` of that child, until the parent's `end`. A modifier is an operation
//! of its own around the node to which it is attached.
//!
//! The array replaces a tree of boxes: a tick walks memory in order, needs no recursion over
//! pointers, and its state is copied into a checkpoint entry by entry. An [`Op`] is small and
//! `Copy`; data that few kinds need is in a table of its kind, at index `side`.

use std::time::Duration;

use super::leaf::{AnyLeaf, Host};
use super::spec::{Abort, Test};
use crate::board::{In, Slot};
use crate::status::{NodeStatus, ResetReason, Status};

/// No child.
// Not an index: a tree has fewer operations.
pub(super) const NONE: u32 = u32::MAX;

/// The kind of an operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Code {
    Leaf,
    Sequence {
        memory: bool,
    },
    Selector {
        memory: bool,
    },
    SequenceWithMemory,
    Parallel,
    Inverter,
    Converter {
        from: Status,
        to: Status,
    },
    PassThrough,
    /// 0: forever.
    Repeat {
        count: u32,
        break_on_failure: bool,
    },
    /// 0: forever. With a `budget`, failures are counted over re-entries.
    Retry {
        count: u32,
        budget: bool,
    },
    /// 0: forever.
    Again {
        count: u32,
        on_failure: bool,
    },
    OneShot {
        on_failure: bool,
    },
    Condition(Status),
    EternalGuard,
    Count,
    Timeout,
    Wait,
    Force(Status),
    Delay,
    Check,
}

impl Code {
    /// The kind of operation in records; an operation of another kind takes no state.
    pub(super) fn tag(self) -> u8 {
        // Part of the format of checkpoints: a number must not get another meaning.
        match self {
            Self::Leaf => 1,
            Self::Sequence { .. } => 2,
            Self::Selector { .. } => 3,
            Self::Parallel => 4,
            Self::Inverter => 5,
            Self::Converter { .. } => 6,
            Self::PassThrough => 7,
            Self::Repeat { .. } => 8,
            Self::Retry { .. } => 9,
            Self::OneShot { .. } => 10,
            Self::Condition(_) => 11,
            Self::EternalGuard => 12,
            Self::Count => 13,
            Self::Timeout => 14,
            Self::Wait => 15,
            Self::Force(_) => 16,
            Self::Delay => 17,
            Self::Check => 18,
            Self::Again { .. } => 19,
            Self::SequenceWithMemory => 20,
        }
    }

    /// Whether it has any number of children.
    pub(super) fn is_composite(self) -> bool {
        matches!(
            self,
            Self::Sequence { .. }
                | Self::SequenceWithMemory
                | Self::Selector { .. }
                | Self::Parallel
        )
    }
}

/// The last result of a guard or check.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Held {
    // Never evaluated: a check that then holds counts as one that holds again, and its first
    // result is reported in either case.
    #[default]
    Unknown = 0,
    No = 1,
    Yes = 2,
}

impl From<bool> for Held {
    fn from(holds: bool) -> Self {
        if holds { Self::Yes } else { Self::No }
    }
}

/// An operation with its state.
#[allow(clippy::struct_excessive_bools, reason = "each is a fact of its own")]
#[derive(Clone, Copy, Debug)]
pub(super) struct Op {
    pub(super) code: Code,
    pub(super) status: NodeStatus,
    /// A result that is held back until everything below has halted.
    pub(super) deferred: Option<Status>,
    /// Of guards and checks.
    pub(super) held: Held,
    /// Why it was stopped, if it was.
    pub(super) reason: ResetReason,
    /// Its status is that of the node: no modifier is around it.
    pub(super) outermost: bool,
    /// A child has a check that may interrupt its siblings.
    pub(super) watches: bool,
    /// Delay: the child may run. Sequence: children beyond the current one may
    /// have run, in an older form of the tree.
    pub(super) open: bool,
    /// The status that was reported last.
    pub(super) shown: NodeStatus,
    /// Its status changed during this tick, perhaps back; or it is never reported, as a
    /// modifier is around it.
    pub(super) touched: bool,
    /// One-shot: the result that it keeps.
    pub(super) last: Option<Status>,
    /// Index of the node in the graph.
    pub(super) node: u16,
    /// Index in the table of its kind.
    pub(super) side: u16,
    /// Index after its last descendant.
    pub(super) end: u32,
    /// Composites: the current child.
    pub(super) cursor: u32,
    /// Repeat: successes. Retry: failures. `SequenceWithMemory`: children that succeeded.
    pub(super) counter: u32,
}

impl Op {
    pub(super) fn new(code: Code, node: u16, outermost: bool) -> Self {
        Self {
            code,
            status: NodeStatus::Invalid,
            deferred: None,
            held: Held::Unknown,
            reason: ResetReason::Explicit,
            outermost,
            watches: false,
            open: false,
            shown: NodeStatus::Invalid,
            touched: !outermost,
            last: None,
            node,
            side: 0,
            end: 0,
            cursor: NONE,
            counter: 0,
        }
    }

    /// The state of an operation that never ran.
    pub(super) fn forget(&mut self) {
        // The fields listed here come from the file and stay; all others are state.
        *self = Self {
            watches: self.watches,
            side: self.side,
            end: self.end,
            ..Self::new(self.code, self.node, self.outermost)
        };
    }
}

/// Of Timeout, Wait and Delay.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timer {
    pub(super) seconds: In<f64>,
    pub(super) deadline: Duration,
}

/// Of a check.
#[derive(Clone, Copy, Debug)]
pub(super) struct Check {
    pub(super) slot: Slot,
    pub(super) test: Test,
    pub(super) abort: Abort,
}

/// Of a parallel.
#[derive(Clone, Debug)]
pub(super) struct Policy {
    pub(super) synchronise: bool,
    pub(super) needs: Needs,
}

/// The children of a parallel that have to succeed.
#[derive(Clone, Debug)]
pub(super) enum Needs {
    All,
    One,
    /// These operations, in the order they were named.
    Selected(Vec<u32>),
    /// See [`super::spec::ParallelPolicy::Count`].
    Count {
        successes: u32,
        failures: u32,
    },
    /// See [`super::spec::ParallelPolicy::Finish`].
    Finish {
        failures: u32,
    },
}

/// The counts of a [`super::Kind::Count`] since the tree was reset.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Ticks of the child.
    pub ticks: u32,
    /// Ticks after which it was running.
    pub running: u32,
    /// Times it succeeded.
    pub successes: u32,
    /// Times it failed.
    pub failures: u32,
    /// Times the node was stopped.
    pub interrupts: u32,
}

/// The arrays.
pub(super) struct Flat<H: Host> {
    pub(super) ops: Vec<Op>,
    pub(super) leaves: Vec<Box<dyn AnyLeaf<H>>>,
    pub(super) timers: Vec<Timer>,
    pub(super) checks: Vec<Check>,
    pub(super) policies: Vec<Policy>,
    pub(super) counts: Vec<Counts>,
}

impl<H: Host> Default for Flat<H> {
    fn default() -> Self {
        Self {
            ops: Vec::new(),
            leaves: Vec::new(),
            timers: Vec::new(),
            checks: Vec::new(),
            policies: Vec::new(),
            counts: Vec::new(),
        }
    }
}
