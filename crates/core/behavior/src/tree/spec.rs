//! A tree as it is written down, before it is made ready to run.

use crate::board::{In, Slot};
use crate::status::Status;
use crate::tree::check::CONDITION;
use crate::tree::leaf::{AnyLeaf, Host, Leaf, any};
use crate::value::Value;

/// Whether a composite continues with its running child, or ticks its children from the
/// first one again at every tick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Continues with the child that was running.
    Yes,
    /// Reactive.
    No,
}

/// When a parallel has succeeded. One child that fails makes it fail.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParallelPolicy {
    /// All children have to succeed.
    All {
        /// A child that succeeded is not ticked again.
        synchronise: bool,
    },
    /// One is enough.
    One,
    /// These children, by index, have to.
    Selected {
        /// Their indices.
        children: Vec<usize>,
        /// As above.
        synchronise: bool,
    },
    /// As `Parallel` of BehaviorTree.CPP: a child that finished is not ticked again; the
    /// count is compared after each child, so those behind the deciding one are not ticked.
    Count {
        /// So many successes are a success; it fails as soon as they cannot be reached.
        successes: u32,
        /// So many failures are a failure.
        failures: u32,
    },
    /// As `ParallelAll` of BehaviorTree.CPP: ends when all children have finished.
    Finish {
        /// So many failures are a failure.
        failures: u32,
    },
}

/// When a one-shot is finished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OneShotPolicy {
    /// After success or failure.
    OnCompletion,
    /// After success; a failure is tried again.
    OnSuccess,
}

/// The kind of a node. Decorators have exactly one child.
pub enum Kind<H: Host> {
    /// Children one after the other until one does not succeed.
    Sequence(Memory),
    /// Children one after the other until one does not fail.
    Selector(Memory),
    /// As `SequenceWithMemory` of BehaviorTree.CPP: it continues with its current child,
    /// also after a failure and after it was stopped, and starts one child a tick.
    SequenceWithMemory,
    /// All children at every tick.
    Parallel(ParallelPolicy),
    /// Swaps success and failure.
    Inverter,
    /// Replaces one status by another.
    Converter {
        /// The replaced status of the child.
        from: Status,
        /// The status that replaces it.
        to: Status,
    },
    /// The child's status.
    PassThrough,
    /// Runs the child until it succeeded `count` times; without a count for ever.
    Repeat {
        /// Number of successes.
        count: Option<u32>,
    },
    /// Runs the child again until it failed `count` times; without a count for ever.
    Retry {
        /// Number of failures.
        count: Option<u32>,
    },
    /// As [`Kind::Repeat`], and [`Kind::Retry`] with `on_failure`, but in the tick in which a
    /// child that was running ends, the next run starts; as `Repeat` and
    /// `RetryUntilSuccessful` of BehaviorTree.CPP.
    Again {
        /// Number of runs.
        count: Option<u32>,
        /// Runs it again until it succeeds, instead of until it fails.
        on_failure: bool,
    },
    /// Runs the child to its end once, and keeps that result.
    OneShot(OneShotPolicy),
    /// Success when the child has this status, running until then.
    Condition(Status),
    /// Evaluates the guard before each tick of the child; fails unless it succeeds.
    EternalGuard(Box<dyn AnyLeaf<H>>),
    /// Counts ticks and results of the child.
    Count,
    /// Fails when the child is not finished after this time (s).
    Timeout(In<f64>),
    /// Runs for this time (s), then succeeds.
    Wait(In<f64>),
    /// A leaf of the host.
    Leaf(Box<dyn AnyLeaf<H>>),
}

/// The nodes that an attached check may interrupt when its result changes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Abort {
    /// None: it is evaluated on entry only.
    #[default]
    None,
    /// Its own node, when it does not hold any more.
    Own,
    /// Siblings to the right, when it holds again.
    LowerPriority,
    /// Both.
    Both,
}

/// The test of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Test {
    /// The key has a value.
    IsSet,
    /// The key has no value.
    IsUnset,
    /// It has this value.
    Equals(Value),
    /// It has another one, or none.
    Differs(Value),
    /// It is a number below this.
    Below(f64),
    /// It is a number above this.
    Above(f64),
}

/// Something attached to a node. The first of a list is the outermost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Modifier {
    /// Runs the node again when it succeeded, one run a tick at most.
    Repeat {
        /// Number of runs, 0 for ever. Then it succeeds.
        count: u32,
        /// A failure ends it; otherwise a failure counts as a run like any other.
        break_on_failure: bool,
    },
    /// Runs the node again when it failed, one run a tick at most.
    Retry {
        /// Largest number of further runs, 0 for ever.
        max: u32,
        /// A success resets the count, and so does a new run of the node. Otherwise
        /// `max` holds until the tree is reset.
        reset_on_success: bool,
    },
    /// Swaps success and failure.
    InvertStatus,
    /// This result when the node is finished, with any result.
    ForceStatus(Status),
    /// Time before the node starts (s).
    Delay(In<f64>),
    /// The node fails when it is not finished after this time (s).
    Timeout(In<f64>),
    /// The node runs only where the test holds.
    CheckBlackboard {
        /// The key.
        slot: Slot,
        /// The test.
        test: Test,
        /// The nodes that it interrupts.
        abort: Abort,
    },
}

impl Modifier {
    /// Its type, as in files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Repeat { .. } => "Repeat",
            Self::Retry { .. } => "Retry",
            Self::InvertStatus => "InvertStatus",
            Self::ForceStatus(_) => "ForceStatus",
            Self::Delay(_) => "Delay",
            Self::Timeout(_) => "Timeout",
            Self::CheckBlackboard { .. } => "CheckBlackboard",
        }
    }
}

/// A node with everything below it.
pub struct Node<H: Host> {
    /// Stable and unique in the tree; state is carried over by it.
    pub id: String,
    /// Name for people.
    pub name: String,
    /// Type as written, `sequence`, `MoveToTarget`.
    pub type_name: String,
    /// Whether it only tests a condition: it returns success or failure, never running.
    pub condition: bool,
    /// Ports, in one line for views.
    pub detail: String,
    /// Its kind.
    pub kind: Kind<H>,
    /// Its modifiers.
    pub modifiers: Vec<Modifier>,
    /// Its children.
    pub children: Vec<Node<H>>,
    /// The part of its id that [`Node::for_each`] added.
    pub suffix: String,
}

impl<H: Host> Node<H> {
    /// A node of `kind`; its name is its id.
    pub fn new(id: &str, type_name: &str, kind: Kind<H>, children: Vec<Self>) -> Self {
        Self {
            id: id.to_owned(),
            name: id.to_owned(),
            type_name: type_name.to_owned(),
            condition: type_name == CONDITION,
            detail: String::new(),
            kind,
            modifiers: Vec::new(),
            children,
            suffix: String::new(),
        }
    }

    /// Children one after the other until one does not succeed.
    pub fn sequence(id: &str, memory: Memory, children: Vec<Self>) -> Self {
        Self::new(id, "sequence", Kind::Sequence(memory), children)
    }

    /// Children one after the other until one does not fail.
    pub fn selector(id: &str, memory: Memory, children: Vec<Self>) -> Self {
        Self::new(id, "selector", Kind::Selector(memory), children)
    }

    /// A sequence of the nodes that `make` gives, one for each item in their order. Their ids,
    /// and names that are ids, end with the item: `bring[red_1]`. State is carried over by ids,
    /// so it is that of the item when items are added or moved.
    pub fn for_each<I: std::fmt::Display>(
        id: &str,
        memory: Memory,
        items: impl IntoIterator<Item = I>,
        mut make: impl FnMut(&I) -> Self,
    ) -> Self {
        // By item and not by number: when items are inserted, each keeps its own state.
        let copies = items.into_iter().map(|item| {
            let mut copy = make(&item);
            copy.add_suffix(&format!("[{item}]"));
            copy
        });
        Self::new(id, "for_each", Kind::Sequence(memory), copies.collect())
    }

    /// Items of inner loops are placed after those of outer ones.
    fn add_suffix(&mut self, outer: &str) {
        let base = self.id.strip_suffix(&self.suffix).unwrap_or(&self.id);
        let id = format!("{base}{outer}{}", self.suffix);
        // A name that the author chose stays as it is.
        if self.name == self.id {
            self.name.clone_from(&id);
        }
        self.id = id;
        self.suffix.insert_str(0, outer);
        for child in &mut self.children {
            child.add_suffix(outer);
        }
    }

    /// An action or condition of the host.
    pub fn leaf(id: &str, type_name: &str, leaf: impl Leaf<H>) -> Self {
        Self::new(id, type_name, Kind::Leaf(any(leaf)), Vec::new())
    }

    /// With a modifier around those it has.
    pub fn with(mut self, modifier: Modifier) -> Self {
        // The first modifier is the outermost.
        self.modifiers.insert(0, modifier);
        self
    }
}
