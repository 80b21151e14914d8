//! A file without its host: every name of a handler is taken for known.

use super::definition::Definition;
use super::ids::Vocabulary;
use super::table::Table;
use crate::machine::Problems;
use crate::machine::alone::add;

impl Definition {
    /// Compiles without a host, to look at and to check.
    ///
    /// # Errors
    /// As [`Definition::compile`].
    pub fn compile_alone(&self) -> Result<Table, Problems> {
        let (mut handlers, mut behaviors) = (Vec::new(), Vec::new());
        for cell in &self.cells {
            add(&mut handlers, std::slice::from_ref(&cell.handler));
        }
        let during = self.states.iter().filter_map(|s| s.during.as_ref());
        during.for_each(|d| add(&mut behaviors, std::slice::from_ref(&d.run)));
        self.compile(&Vocabulary {
            events: &[],
            states: &[],
            handlers: &handlers,
            behaviors: &behaviors,
        })
    }
}
