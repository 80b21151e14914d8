//! A file without its host: every name of a handler counts as known.

use super::definition::Definition;
use super::ids::Vocabulary;
use super::table::Table;
use crate::machine::Problems;
use crate::machine::alone::Once;

impl Definition {
    /// Compiles without a host, to draw and to check.
    ///
    /// # Errors
    /// As [`Definition::compile`].
    pub fn compile_alone(&self) -> Result<Table, Problems> {
        let (mut handlers, mut behaviors) = (Once::default(), Once::default());
        for cell in &self.cells {
            handlers.add(std::slice::from_ref(&cell.handler));
        }
        let during = self.states.iter().filter_map(|s| s.during.as_ref());
        during.for_each(|d| behaviors.add(std::slice::from_ref(&d.run)));
        self.compile(&Vocabulary {
            events: &[],
            states: &[],
            handlers: &handlers.names,
            behaviors: &behaviors.names,
        })
    }
}
