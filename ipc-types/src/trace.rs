//! What the task did and why, line by line.

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
    }
}

wire! {
    /// One line of the task's log; `header.tick` is the tick it was written at.
    pub struct TraceLine {
        /// Header.
        pub header: Header,
        /// [`TraceKind`].
        pub kind: u32,
        /// Zero.
        pub reserved: u32,
        /// The line.
        pub text: Text<168>,
    }
}

impl Validate for TraceLine {
    fn validate(&self) -> Result<(), Invalid> {
        Check::code("kind", self.kind, TraceKind::from_code(self.kind).is_some())?;
        self.text.check("text")
    }
}
