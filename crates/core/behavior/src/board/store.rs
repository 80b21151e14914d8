//! The store of one scope.

use serde::{Deserialize, Serialize};

use super::Client;
use super::bytes::name_hash;
use crate::suggest;
use crate::value::{Value, ValueType};

/// One of the two boards of a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Scope {
    /// The tree's local board.
    Local,
    /// Shared by all trees of a host.
    Shared,
}

/// What a client may do with a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Access {
    /// Read it.
    Read,
    /// Write it, and read what was written.
    Write,
    /// Write it, and no other client may.
    Exclusive,
}

/// A key as declared.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyInfo {
    /// Its name within the board, `/robot/x` with its namespace.
    pub name: String,
    /// Type of its value.
    pub value_type: ValueType,
    /// Value after a reset.
    pub default: Option<Value>,
    /// It is for people and other programs, so no node has to read it.
    pub observed: bool,
}

/// Why a board refuses a declaration or a registration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BoardError {
    /// The key is not declared.
    #[error("unknown blackboard key '{key}'; {advice}")]
    Unknown {
        /// The key.
        key: String,
        /// The nearest one, or all.
        advice: String,
    },
    /// Declared twice with different types or defaults.
    #[error("blackboard key '{key}' is declared as {first} and as {second}; declare it once")]
    Conflict {
        /// The key.
        key: String,
        /// Type of the first declaration.
        first: &'static str,
        /// Type of the second.
        second: &'static str,
    },
    /// The type of the key is not that of the port.
    #[error("blackboard key '{key}' is {found}, {wanted} is needed")]
    Type {
        /// The key.
        key: String,
        /// Its type.
        found: &'static str,
        /// The type of the port.
        wanted: &'static str,
    },
    /// Another client has exclusive access.
    #[error("'{client}' cannot write blackboard key '{key}': '{holder}' writes it exclusively")]
    Exclusive {
        /// The client that was refused.
        client: String,
        /// The key.
        key: String,
        /// The client with exclusive access.
        holder: String,
    },
    /// A key that is read has no value.
    #[error("'{client}' reads blackboard key '{key}', which has no value; give it a default")]
    Unset {
        /// The client that reads it.
        client: String,
        /// The key.
        key: String,
    },
    /// A default that is not of the declared type, or not finite.
    #[error("the default of blackboard key '{key}' is {value}, a finite {wanted} is needed")]
    Default {
        /// The key.
        key: String,
        /// The value.
        value: Value,
        /// The declared type.
        wanted: &'static str,
    },
}

#[derive(Clone, Debug)]
struct Key {
    info: KeyInfo,
    /// Of its name, for records.
    hash: u64,
    value: Option<Value>,
    /// Clients by number, with their registered access.
    clients: Vec<(usize, Access)>,
}

/// The keys of one scope and their values.
#[derive(Clone, Debug, Default)]
pub struct Board {
    keys: Vec<Key>,
    /// Number of the tree that registered it, and its name.
    clients: Vec<(u32, String)>,
    /// Trees that have registered so far.
    trees: u32,
}

impl Board {
    /// A board without keys.
    pub fn new() -> Self {
        Self::default()
    }

    /// Declares a key; declaring it again with the same type changes nothing.
    ///
    /// # Errors
    /// [`BoardError::Conflict`], and [`BoardError::Default`].
    pub fn declare(
        &mut self,
        name: &str,
        value_type: ValueType,
        default: Option<Value>,
    ) -> Result<usize, BoardError> {
        // Before the key exists: a default is stored without the check of `set`.
        if let Some(value) = default
            && (value.value_type() != value_type || !is_finite(value))
        {
            return Err(BoardError::Default {
                key: name.to_owned(),
                value,
                wanted: value_type.name(),
            });
        }
        // Several nodes may declare one key; they have to agree on its type.
        if let Some(index) = self.index(name) {
            let first = self.keys.get(index).map(|k| k.info.value_type);
            return match first {
                Some(first) if first != value_type => Err(BoardError::Conflict {
                    key: name.to_owned(),
                    first: first.name(),
                    second: value_type.name(),
                }),
                _ => Ok(index),
            };
        }
        self.keys.push(Key {
            info: KeyInfo {
                name: name.to_owned(),
                value_type,
                default,
                observed: false,
            },
            hash: name_hash(name),
            value: default,
            clients: Vec::new(),
        });
        Ok(self.keys.len() - 1)
    }

    /// Registers the access of `client` to `key`, and returns the index of the key.
    ///
    /// # Errors
    /// [`BoardError`] for an unknown key, one of another type, and where another client writes
    /// it exclusively, or prevents an exclusive access of `client`.
    pub fn register(
        &mut self,
        client: &str,
        key: &str,
        value_type: ValueType,
        access: Access,
    ) -> Result<usize, BoardError> {
        let number = self.client_number(client);
        self.register_as(number, key, value_type, access)
    }

    pub(super) fn register_as(
        &mut self,
        number: usize,
        key: &str,
        value_type: ValueType,
        access: Access,
    ) -> Result<usize, BoardError> {
        let index = self.index(key).ok_or_else(|| self.unknown(key))?;
        let name = |client: usize| {
            let client = self.clients.get(client);
            client.map_or_else(String::new, |(_, name)| name.clone())
        };
        let Some(entry) = self.keys.get_mut(index) else {
            return Ok(index);
        };
        if entry.info.value_type != value_type {
            return Err(BoardError::Type {
                key: key.to_owned(),
                found: entry.info.value_type.name(),
                wanted: value_type.name(),
            });
        }
        let in_the_way = |other: &(usize, Access)| {
            // Reading never conflicts: exclusive access is about writers.
            other.0 != number
                && match access {
                    Access::Read => false,
                    Access::Write => other.1 == Access::Exclusive,
                    Access::Exclusive => other.1 != Access::Read,
                }
        };
        if let Some((holder, _)) = entry.clients.iter().find(|c| in_the_way(c)) {
            return Err(BoardError::Exclusive {
                client: name(number),
                key: key.to_owned(),
                holder: name(*holder),
            });
        }
        if !entry.clients.contains(&(number, access)) {
            entry.clients.push((number, access));
        }
        Ok(index)
    }

    /// The following clients belong to another tree, also if their names are the same: two
    /// trees of one file have nodes with the same names.
    pub fn next_tree(&mut self) {
        self.trees += 1;
    }

    /// A client that accesses keys by name while ticking.
    pub fn client(&mut self, name: &str) -> Client {
        Client::new(self.client_number(name), "")
    }

    /// As [`Board::client`]; `x` means `/NAMESPACE/x`.
    pub fn client_in(&mut self, name: &str, namespace: &str) -> Client {
        Client::new(self.client_number(name), namespace)
    }

    /// Marks a key as meant for people and other programs, see [`KeyInfo::observed`].
    pub fn observe(&mut self, index: usize) {
        if let Some(key) = self.keys.get_mut(index) {
            key.info.observed = true;
        }
    }

    /// Index of a key.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.keys.iter().position(|k| k.info.name == name)
    }

    /// The keys in the order of their declaration.
    pub fn keys(&self) -> impl Iterator<Item = &KeyInfo> {
        self.keys.iter().map(|k| &k.info)
    }

    /// Names of the clients of the key at `index`, with their access.
    pub fn users(&self, index: usize) -> impl Iterator<Item = (&str, Access)> {
        let entry = self.keys.get(index);
        let clients = entry.map(|k| k.clients.as_slice()).unwrap_or_default();
        clients.iter().map(|(number, access)| {
            let name = self.clients.get(*number).map_or("", |(_, n)| n.as_str());
            (name, *access)
        })
    }

    /// Value of the key at `index`, `None` if it has none.
    pub fn value(&self, index: usize) -> Option<Value> {
        self.keys.get(index)?.value
    }

    /// As [`Board::value`], without a copy.
    pub(crate) fn value_ref(&self, index: usize) -> Option<&Value> {
        self.keys.get(index)?.value.as_ref()
    }

    /// How many keys there are.
    pub(crate) fn len(&self) -> usize {
        self.keys.len()
    }

    /// Hashes of the names with the values, in the order of declaration.
    pub(super) fn hashed(&self) -> impl Iterator<Item = (u64, Option<&Value>)> {
        self.keys.iter().map(|k| (k.hash, k.value.as_ref()))
    }

    /// Gives the key at `index` a value. `false`, and no change, for a value of
    /// another type, one that is not finite, or an index out of range.
    pub fn set(&mut self, index: usize, value: Value) -> bool {
        match self.keys.get_mut(index) {
            // A NaN on the board would make every comparison of a check false, without a fault.
            Some(key) if key.info.value_type == value.value_type() && is_finite(value) => {
                key.value = Some(value);
                true
            }
            _ => false,
        }
    }

    /// Removes the value of the key at `index`.
    pub fn unset(&mut self, index: usize) {
        if let Some(key) = self.keys.get_mut(index) {
            key.value = None;
        }
    }

    /// Resets every key to its default.
    pub fn reset(&mut self) {
        for key in &mut self.keys {
            key.value = key.info.default;
        }
    }

    pub(super) fn allows(&self, index: usize, client: usize, write: bool) -> bool {
        self.keys.get(index).is_some_and(|key| {
            key.clients
                .iter()
                .any(|(number, access)| *number == client && (!write || *access != Access::Read))
        })
    }

    /// The first key that this client registered for reading and that has no
    /// value.
    pub(super) fn first_unset(&self, client: usize) -> Option<&KeyInfo> {
        let waits =
            |key: &&Key| key.value.is_none() && key.clients.contains(&(client, Access::Read));
        self.keys.iter().find(waits).map(|key| &key.info)
    }

    pub(super) fn client_name(&self, number: usize) -> &str {
        self.clients.get(number).map_or("", |(_, n)| n.as_str())
    }

    fn client_number(&mut self, name: &str) -> usize {
        // With the number of the tree: two trees of one file must not share the rights of a
        // client.
        let own = |(tree, known): &(u32, String)| *tree == self.trees && known == name;
        let known = self.clients.iter().position(own);
        known.unwrap_or_else(|| {
            self.clients.push((self.trees, name.to_owned()));
            self.clients.len() - 1
        })
    }

    fn unknown(&self, key: &str) -> BoardError {
        let names: Vec<&str> = self.keys().map(|k| k.name.as_str()).collect();
        BoardError::Unknown {
            key: key.to_owned(),
            advice: suggest::advice(key, &names),
        }
    }
}

pub(super) fn is_finite(value: Value) -> bool {
    match value {
        Value::Number(number) => number.is_finite(),
        Value::Numbers(numbers) => numbers.as_slice().iter().all(|n| n.is_finite()),
        _ => true,
    }
}
