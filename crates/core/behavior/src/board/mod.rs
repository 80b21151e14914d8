//! Blackboards: typed keys with declared access.
//!
//! A [`Board`] is the store of one scope. A user registers each key with
//! the access it needs when it is built, and gets a handle with exactly that
//! access: [`In`] reads, [`Out`] writes. Access by name while ticking uses
//! a [`Client`], which refuses keys that were not registered.

pub(crate) mod bytes;
mod client;
mod record;
mod store;

pub use bytes::{Carried, RecordError};
pub use client::Client;
pub use store::{Access, Board, BoardError, KeyInfo, Scope};

use crate::value::{Plain, Value};

/// A place on one of the two boards of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Which board.
    pub scope: Scope,
    /// Index of the key on it.
    pub index: usize,
}

/// Source of an input.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum In<T> {
    /// Written in the descriptor.
    Literal(T),
    /// Read from a board at every use.
    Key(Slot),
}

/// Target of an output: a key that may also be read, if that was requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Out<T> {
    /// The key.
    pub slot: Slot,
    /// Whether it was registered for writing.
    pub(crate) writable: bool,
    kind: std::marker::PhantomData<fn() -> T>,
}

impl<T> Out<T> {
    /// A handle on `slot`, whose key has to hold a `T`.
    pub(crate) fn new(slot: Slot, writable: bool) -> Self {
        Self {
            slot,
            writable,
            kind: std::marker::PhantomData,
        }
    }
}

/// Why a value could not be read or written while ticking. The node fails, and the tree
/// reports the fault.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The key has no value yet.
    #[error("a blackboard key was read before it was written; give it a default")]
    Unset(Slot),
    /// The value is of another type or length than the port.
    #[error("a blackboard key holds {found}, which the port cannot use")]
    Type {
        /// The key.
        slot: Slot,
        /// Its value.
        found: Value,
    },
    /// The client did not register that access to the key.
    #[error("the key was not registered for that access; register it when the node is built")]
    Access,
    /// A number was not finite.
    #[error("a number written to a blackboard is not finite")]
    NotFinite(Slot),
    /// The node's own reason.
    #[error("{0}")]
    Node(&'static str),
}

impl<T: Plain> In<T> {
    /// The input's value.
    ///
    /// # Errors
    /// [`Fault`] when the key has no value, or one of another type.
    pub fn get(&self, local: &Board, shared: &Board) -> Result<T, Fault> {
        match self {
            Self::Literal(value) => Ok(*value),
            Self::Key(slot) => slot.get(local, shared),
        }
    }
}

impl Slot {
    /// The value in this place.
    ///
    /// # Errors
    /// As [`In::get`].
    pub fn get<T: Plain>(self, local: &Board, shared: &Board) -> Result<T, Fault> {
        let board = match self.scope {
            Scope::Local => local,
            Scope::Shared => shared,
        };
        let value = board.value_ref(self.index).ok_or(Fault::Unset(self))?;
        T::from_value(*value).ok_or(Fault::Type {
            slot: self,
            found: *value,
        })
    }
}
