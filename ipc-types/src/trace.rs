//! The trace of the task: its actions and their reasons, line by line.

use crate::Text;
use crate::header::Header;
use crate::validate::{Check, Invalid, Validate, code};
use crate::wire::wire;

code! {
    /// Kind of a trace line.
    pub enum TraceKind {
        /// A log line of the policy, `[decide] -> stack red_cube`.
        Log = 0,
        /// A phase was left for another.
        Transition = 1,
        /// The policy was started, restored or reset.
        Lifecycle = 2,
        /// A node changed from status `from` to `to`; `text` is the reason.
        Status = 3,
        /// A guard was evaluated: `text` is its name, `to` is 1 if it holds.
        Guard = 4,
        /// A blackboard key has a new value: `text` is `key=value`.
        Key = 5,
        /// Part of the picture: node `node` of `to`, child of node `from` - 1 (0: no parent);
        /// `text` is the name of the picture, then id, kind, name and detail of the node,
        /// separated by [`FIELD_END`].
        Node = 6,
        /// Part of the picture: an edge from node `from` to node `to`.
        Edge = 7,
        /// Statuses of the nodes from `node` on, a letter each.
        Statuses = 8,
    }
}

impl TraceKind {
    /// Whether a line of this kind is for people, not only for programs that draw pictures.
    pub fn is_for_people(self) -> bool {
        matches!(self, Self::Log | Self::Transition | Self::Lifecycle)
    }
}

code! {
    /// Meaning of a line for people, for programs: the page marks these on its timeline,
    /// regardless of the words.
    // Codes and not words: the page must not break when a sentence is improved.
    pub enum TraceEvent {
        /// Not marked.
        None = 0,
        /// A held object was lost.
        Drop = 1,
        /// A pick-up was started again because the object moved.
        Resync = 2,
        /// A transfer was turned back.
        Abort = 3,
        /// A recovery of any other kind.
        Recover = 4,
        /// The job, or the part of one arm, is done.
        Done = 5,
        /// The job failed, or the policy did.
        Fault = 6,
        /// The task was restarted: from a checkpoint, without one, or by the
        /// operator.
        Restart = 7,
        /// The grip of a suction cup broke at a limit.
        GripBroke = 8,
        /// A gripper that a person closed holds something.
        Hand = 9,
        /// What a person did by hand failed.
        HandFailed = 10,
    }
}

impl TraceEvent {
    /// Its name on the page and in recordings; `None` for [`TraceEvent::None`].
    pub fn name(self) -> Option<&'static str> {
        match self {
            Self::None => None,
            Self::Drop => Some("drop"),
            Self::Resync => Some("resync"),
            Self::Abort => Some("abort"),
            Self::Recover => Some("recover"),
            Self::Done => Some("done"),
            Self::Fault => Some("fault"),
            Self::Restart => Some("restart"),
            Self::GripBroke => Some("break"),
            Self::Hand => Some("hand"),
            Self::HandFailed => Some("hand_failed"),
        }
    }
}

/// Separates the fields of a [`TraceKind::Node`] line.
// The unit separator of ASCII: made for this, and not a character of names.
pub const FIELD_END: char = '\u{1f}';

/// Bytes of a line's text.
// Fits a status line of 160 nodes; with 1,024 lines waiting, a reader's buffer is 0.35 MB.
pub const LINE_BYTES: usize = 160;

wire! {
    /// One line of the task's trace; `header.tick` is the tick it was written at.
    pub struct TraceLine {
        /// Header.
        pub header: Header,
        /// [`TraceKind`].
        pub kind: u32,
        /// Which of the policy's graphs, from 0 up.
        pub graph: u32,
        /// Which node of it.
        pub node: u32,
        /// See [`TraceKind`].
        pub from: u32,
        /// See [`TraceKind`].
        pub to: u32,
        /// [`TraceEvent`].
        pub event: u32,
        /// The line.
        pub text: Text<LINE_BYTES>,
    }
}

impl Validate for TraceLine {
    // A reader draws from these numbers, so unknown ones are refused instead of guessed.
    fn validate(&self) -> Result<(), Invalid> {
        Check::code("kind", self.kind, TraceKind::from_code(self.kind).is_some())?;
        Check::code(
            "event",
            self.event,
            TraceEvent::from_code(self.event).is_some(),
        )?;
        self.text.check("text")
    }
}
