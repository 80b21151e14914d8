//! Access by name, checked at each use.

use super::store::{Access, Board, BoardError, Scope};
use super::{Fault, Slot};
use crate::value::{Plain, Value};

/// A user that accesses keys by name while ticking, where a handle per key
/// would be too rigid. A key that was not registered is refused.
#[derive(Clone, Debug)]
pub struct Client {
    number: usize,
    namespace: String,
}

impl Client {
    pub(super) fn new(number: usize, namespace: &str) -> Self {
        Self {
            number,
            namespace: namespace.trim_matches('/').to_owned(),
        }
    }

    /// The name on the board of this client's `key`.
    pub fn absolute(&self, key: &str) -> String {
        if key.starts_with('/') || self.namespace.is_empty() {
            key.to_owned()
        } else {
            format!("/{}/{key}", self.namespace)
        }
    }

    /// Declares `key` for a `T` and registers this access to it.
    ///
    /// # Errors
    /// As [`Board::declare`] and [`Board::register`].
    pub fn register<T: Plain>(
        &self,
        board: &mut Board,
        key: &str,
        access: Access,
    ) -> Result<(), BoardError> {
        let name = self.absolute(key);
        board.declare(&name, T::TYPE, None)?;
        board.register_as(self.number, &name, T::TYPE, access)?;
        Ok(())
    }

    /// Whether `key` has a value.
    ///
    /// # Errors
    /// [`Fault::Access`] for a key that was not registered.
    pub fn exists(&self, board: &Board, key: &str) -> Result<bool, Fault> {
        Ok(board.value(self.find(board, key, false)?).is_some())
    }

    /// Reads `key`.
    ///
    /// # Errors
    /// [`Fault`] for a key that was not registered, has no value, or one of
    /// another type.
    pub fn get<T: Plain>(&self, board: &Board, key: &str) -> Result<T, Fault> {
        let slot = Slot {
            scope: Scope::Local,
            index: self.find(board, key, false)?,
        };
        slot.get(board, board)
    }

    /// Writes `key`.
    ///
    /// # Errors
    /// [`Fault`] for a key that was not registered for writing, and for a value
    /// that is not finite or of another type.
    pub fn set<T: Plain>(&self, board: &mut Board, key: &str, value: T) -> Result<(), Fault> {
        let index = self.find(board, key, true)?;
        let value: Value = value.into_value();
        if board.set(index, value) {
            return Ok(());
        }
        Err(Fault::NotFinite(Slot {
            scope: Scope::Local,
            index,
        }))
    }

    /// Removes the value of `key`.
    ///
    /// # Errors
    /// [`Fault::Access`] for a key that was not registered for writing.
    pub fn unset(&self, board: &mut Board, key: &str) -> Result<(), Fault> {
        let index = self.find(board, key, true)?;
        board.unset(index);
        Ok(())
    }

    /// Whether every key it reads has a value, for a check before the start.
    ///
    /// # Errors
    /// [`BoardError::Unset`] with the first that has none.
    pub fn verify(&self, board: &Board) -> Result<(), BoardError> {
        match board.first_unset(self.number) {
            None => Ok(()),
            Some(key) => Err(BoardError::Unset {
                client: board.client_name(self.number).to_owned(),
                key: key.name.clone(),
            }),
        }
    }

    fn find(&self, board: &Board, key: &str, write: bool) -> Result<usize, Fault> {
        // The namespace is compared part by part: a name that is built for each access would
        // allocate within a tick.
        let found = if key.starts_with('/') || self.namespace.is_empty() {
            board.index(key)
        } else {
            board
                .keys()
                .position(|known| self.names(known.name.as_str(), key))
        };
        found
            // One error for unknown and for not registered: the key may belong to another
            // client.
            .filter(|index| board.allows(*index, self.number, write))
            .ok_or(Fault::Access)
    }

    /// Whether the board's `name` is this client's `key`, without building the full name.
    fn names(&self, name: &str, key: &str) -> bool {
        let rest = name.strip_prefix('/');
        let rest = rest.and_then(|r| r.strip_prefix(self.namespace.as_str()));
        rest.and_then(|r| r.strip_prefix('/')) == Some(key)
    }
}
