//! Leaves that a file declares: how a library makes them.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

use super::binder::BindError;
use super::declared::DeclaredLeaf;
use super::leaf::{AnyLeaf, Cx, Host, Leaf, any};
use super::library::Library;
use crate::board::Fault;
use crate::status::Status;

/// Replaces a leaf in a tree that is only checked or drawn.
struct Placeholder;

impl<H: Host> Leaf<H> for Placeholder {
    type State = ();

    fn tick(&self, (): &mut (), _: &mut Cx<'_, '_, H>) -> Result<Status, Fault> {
        // Never ticked by `check` and `show`; an error and not a status, should one run it.
        Err(Fault::Node("a declared leaf that no program provides"))
    }
}

impl<H: Host> Library<H> {
    /// With `make` for leaves of the types that a file declares under `leaves`. Without it,
    /// such a file is refused.
    pub fn with_declared(
        mut self,
        make: impl Fn(DeclaredLeaf) -> Result<Box<dyn AnyLeaf<H>>, BindError> + Send + Sync + 'static,
    ) -> Self {
        self.declared = Some(Box::new(make));
        self
    }

    /// For files that are only checked or drawn: declared leaves get no implementation.
    pub fn with_placeholders(self) -> Self {
        self.with_declared(|_| Ok(any(Placeholder)))
    }
}
