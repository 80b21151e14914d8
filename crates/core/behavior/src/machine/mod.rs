//! Declarative machines: states, and rows of trigger, source, guards and
//! destination, with the semantics of `transitions` 0.9.
//!
//! Deliberate differences, each because the original behaviour hides mistakes:
//! - Names without a meaning are refused at load, with their place. `transitions` accepts an
//!   undefined destination: the trigger then runs the exit callbacks, raises an error, and
//!   leaves the machine in the source.
//! - A guard is evaluated at most once for each trigger, so of two rows with
//!   opposite guards exactly one is taken.
//! - Triggers fired in callbacks always wait until the current one is done;
//!   there is no immediate mode.
//! - `prepare_event` runs once for each trigger, also if several levels are tried.
//! - `may` evaluates guards only, and runs no callback.
//! - Entering one region of a parallel state from outside enters all.
//! - A row that leaves a parallel state ends the trigger for the states that were left.
//!
//! ```
//! use behavior::machine::{Actions, CallbackId, Definition, Event, Fault, GuardId};
//! use behavior::machine::{Machine, RowDef, Vocabulary};
//!
//! struct Door { locked: bool }
//! impl Actions for Door {
//!     fn guard(&mut self, _: GuardId) -> bool { self.locked }
//!     fn call(&mut self, _: CallbackId, _: &mut Event<'_>) -> Result<(), Fault> { Ok(()) }
//! }
//!
//! let vocabulary = Vocabulary { guards: &["locked"], ..Vocabulary::default() };
//! let table = Definition::new("door")
//!     .states(&["closed", "open"])
//!     .row(RowDef::new("push", "closed", "open").unless(&["locked"]))
//!     .row(RowDef::new("pull", "open", "closed"))
//!     .compile(&vocabulary)?;
//! let push = table.trigger("push").ok_or("no such trigger")?;
//! let mut machine = Machine::new(table.into());
//! assert!(!machine.trigger(push, &mut Door { locked: true })?.taken);
//! assert!(machine.trigger(push, &mut Door { locked: false })?.taken);
//! assert_eq!(machine.state_name(), "open");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod actions;
pub(crate) mod alone;
mod ask;
mod change;
mod check;
mod check_events;
mod compile;
mod definition;
mod graph;
mod guards;
mod ids;
mod nesting;
pub(crate) mod problem;
pub(crate) mod read;
pub(crate) mod record;
mod runtime;
mod schema;
pub(crate) mod set;
mod table;
pub(crate) mod trace;

pub use actions::{Actions, Event, Fault, QUEUE_CAPACITY, QueueFull};
pub use check::{check, check_with_ends, unhandled};
pub use check_events::check_events;
pub use definition::{
    Definition, DestDef, DuringDef, Final, Name, OrderedDef, RowDef, SourceDef, StateDef, names,
};
pub use ids::{BehaviorId, CallbackId, GuardId, RowId, StateId, TriggerId, Vocabulary};
pub use problem::{Location, Problem, Problems};
pub use record::RestoreError;
pub use runtime::{Fired, MAX_EVENTS, Machine, TriggerError};
pub use schema::schema;
pub use set::MAX_MEMBERS;
pub use table::Table;
pub use trace::{Happening, TRACE_CAPACITY};
