//! The event x state matrix: for each state and event a handler, or nothing.
//!
//! Events have an explicit precedence: of the pending events, the first in
//! the list is handled. A cell that is not filled in has no effect. A
//! handler stays or changes to a state that its cell declares.
//!
//! ```
//! use behavior::matrix::{Cell, CellDef, Definition, EventSet, HandlerId, Handlers, Matrix};
//! use behavior::matrix::{Next, Vocabulary};
//! use behavior::machine::Fault;
//!
//! struct Lamp;
//! impl Handlers for Lamp {
//!     fn handle(&mut self, _: HandlerId, cell: Cell<'_>) -> Result<Next, Fault> {
//!         Ok(cell.goto.first().map_or(Next::Stay, |state| Next::Goto(*state)))
//!     }
//! }
//!
//! let table = Definition::new("lamp", &["BROKEN", "PRESSED"], &["off", "on"])
//!     .cell(CellDef::new("off", "PRESSED", "light").goto(&["on"]))
//!     .cell(CellDef::new("on", "PRESSED", "darken").goto(&["off"]))
//!     .compile(&Vocabulary { handlers: &["light", "darken"], ..Vocabulary::default() })?;
//! let pressed = table.event("PRESSED").ok_or("no such event")?;
//! let mut matrix = Matrix::new(table.into());
//! matrix.step(pressed, &mut Lamp)?;
//! assert_eq!(matrix.state_name(), "on");
//! assert_eq!(matrix.table().pick(EventSet::EMPTY.with(pressed)), Some(pressed));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod alone;
mod check;
mod compile;
mod definition;
mod graph;
mod ids;
mod read;
mod runtime;
mod table;

pub use check::{check, check_with_ends, unhandled};
pub use definition::{CellDef, Definition, DuringDef, StateDef};
pub use ids::{EventId, EventSet, HandlerId, MAX_EVENTS, Vocabulary};
pub use runtime::{Cell, Handlers, Happening, Matrix, Next, StepError};
pub use table::Table;
