//! Blackboards: typed keys with declared access.
//!
//! A [`Board`] is the store of one scope. Who uses it registers each key with
//! the access it needs when it is built, and gets a handle that can do exactly
//! that: [`In`] reads, [`Out`] writes. Access by name while ticking goes
//! through a [`Client`], which refuses what was not registered.

pub(crate) mod bytes;
mod client;
mod record;
mod store;

pub use bytes::{Carried, RecordError};
pub use client::Client;
pub use store::{Access, Board, BoardError, KeyInfo, Scope};

use crate::value::{Plain, Value};

/// A place on one of the two boards a tree sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Which board.
    pub scope: Scope,
    /// Index of the key on it.
    pub index: usize,
}

/// Where an input comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum In<T> {
    /// Written in the descriptor.
    Literal(T),
    /// Read from a board at every use.
    Key(Slot),
}

/// Where an output goes: a key that may be read, too, if it was asked for.
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

/// Why a value could not be read or written while ticking. The node that asked
/// fails, and the tree reports it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// The key has no value yet.
    #[error("a blackboard key was read before it was written; give it a default")]
    Unset(Slot),
    /// The value is of another type or length than the port.
    #[error("a blackboard key holds {found}, not what the port needs")]
    Type {
        /// The key.
        slot: Slot,
        /// What it holds.
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
