//! Leaves whose types are declared in the tree file, for hosts that know them by name only.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

use super::binder::BindError;
use super::leaf::{AnyLeaf, Cx, Host};
use crate::board::{Fault, In, Scope};
use crate::value::{Value, ValueType};

/// A leaf as the file describes it: the data from which a host makes it.
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredLeaf {
    /// Its type.
    pub type_name: String,
    /// Id of the node.
    pub node: String,
    /// The bound ports, in the order of their declaration.
    pub ports: Vec<DeclaredPort>,
}

/// A bound port of a [`DeclaredLeaf`].
#[derive(Clone, Debug, PartialEq)]
pub struct DeclaredPort {
    /// Its name.
    pub name: String,
    /// Type of its value; `None` for any.
    pub value_type: Option<ValueType>,
    /// The literal or the key.
    pub from: In<Value>,
    /// Whether it was registered for writing.
    pub writable: bool,
}

impl DeclaredPort {
    /// Its value; `None` for a key that has none.
    pub fn get<H: Host>(&self, cx: &mut Cx<'_, '_, H>) -> Option<Value> {
        match self.from {
            In::Literal(value) => Some(value),
            In::Key(slot) => match slot.scope {
                Scope::Local => cx.local.value(slot.index),
                Scope::Shared => cx.shared.value(slot.index),
            },
        }
    }

    /// Writes its key.
    ///
    /// # Errors
    /// [`Fault::Access`] for a literal, or a port that only reads;
    /// [`Fault::NotFinite`] for a value of another type, or one that is not finite.
    pub fn set<H: Host>(&self, cx: &mut Cx<'_, '_, H>, value: Value) -> Result<(), Fault> {
        // The registered access must hold for declared leaves as well: the board itself does
        // not know the writer.
        let (In::Key(slot), true) = (self.from, self.writable) else {
            return Err(Fault::Access);
        };
        if cx.board(slot.scope).set(slot.index, value) {
            Ok(())
        } else {
            Err(Fault::NotFinite(slot))
        }
    }
}

/// Makes a leaf of a declared type.
pub(crate) type MakeDeclared<H> =
    Box<dyn Fn(DeclaredLeaf) -> Result<Box<dyn AnyLeaf<H>>, BindError> + Send + Sync>;
