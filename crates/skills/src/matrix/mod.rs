//! Jobs that are a matrix of events and states in a file, with handlers in Rust.

mod run;

use behavior::matrix::{Definition, Table, Vocabulary};
use cell_model::Cell;
use robocell_task::SetupError;
use robocell_task::settings::behaviour_text;

use crate::named::Named;
pub use run::{MatrixRun, goto, pending};

/// The matrix in the behaviour file of that name, of events `E`, states `S` and
/// handlers `H`.
///
/// # Errors
/// [`SetupError`] with everything that is wrong in the file, each with line and
/// column: a name without an implementation, too.
pub fn table<E: Named, S: Named, H: Named>(cell: &Cell, name: &str) -> Result<Table, SetupError> {
    let text = behaviour_text(cell, name)?;
    let vocabulary = Vocabulary {
        events: E::NAMES,
        states: S::NAMES,
        handlers: H::NAMES,
        behaviors: &[],
    };
    Definition::load(&format!("cells/{name}"), &text, &vocabulary)
        .map_err(|problems| SetupError::new(cell, problems.to_string()))
}
