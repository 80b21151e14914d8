//! The ports of a node in a file, as the constructor of its type receives them.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

use std::collections::BTreeMap;

use crate::board::{Access, Board, BoardError, In, Out, Scope, Slot};
use crate::finding::Finding;
use crate::suggest;
use crate::value::{Plain, Value};

/// The binding of a port of a node in the file.
#[derive(Clone, Debug, PartialEq)]
pub enum Binding {
    /// A value.
    Literal(Value),
    /// A key of a board.
    Key(Scope, String),
}

/// Why a node cannot be made from its ports.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BindError {
    /// The type declares no such port.
    #[error("unknown port '{port}'; {advice}")]
    Unknown {
        /// The port.
        port: String,
        /// The nearest one.
        advice: String,
    },
    /// It is not bound and has no default.
    #[error("port '{port}' is missing; give it {wanted}")]
    Missing {
        /// The port.
        port: String,
        /// Type of its value.
        wanted: &'static str,
    },
    /// A literal of another type.
    #[error("port '{port}' is {found}, {wanted} is needed")]
    Type {
        /// The port.
        port: String,
        /// Its binding.
        found: String,
        /// The needed type.
        wanted: String,
    },
    /// The board.
    #[error("port '{port}': {source}")]
    Board {
        /// The port or key.
        port: String,
        /// Its error.
        source: Box<BoardError>,
    },
    /// A name that the host's world does not have.
    #[error("{0}")]
    Host(String),
}

/// Gives a node its bound ports, and registers every key that it uses.
pub struct Binder<'b> {
    /// Id of the node, the name it registers under.
    pub node: &'b str,
    /// Bound ports by name; defaults filled in.
    pub bindings: &'b BTreeMap<String, Binding>,
    /// Constants of the file and of the instance, by name.
    pub constants: &'b BTreeMap<String, Value>,
    /// The tree's own board.
    pub local: &'b mut Board,
    /// The board shared by the trees of a host.
    pub shared: &'b mut Board,
    /// Probable mistakes.
    pub findings: &'b mut Vec<Finding>,
}

impl Binder<'_> {
    /// The input `port`.
    ///
    /// # Errors
    /// [`BindError`] where it is missing or of another type.
    pub fn input<T: Plain>(&mut self, port: &str) -> Result<In<T>, BindError> {
        match self.binding::<T>(port)? {
            Binding::Key(scope, key) => {
                Ok(In::Key(self.slot::<T>(scope, &key, Access::Read, port)?))
            }
            Binding::Literal(value) => match T::from_value(value) {
                Some(value) => Ok(In::Literal(value)),
                None => Err(wrong_type::<T>(port, value.to_string())),
            },
        }
    }

    /// The output `port`.
    ///
    /// # Errors
    /// [`BindError`] where it is missing, a literal, or not writable.
    pub fn output<T: Plain>(&mut self, port: &str) -> Result<Out<T>, BindError> {
        match self.binding::<T>(port)? {
            Binding::Key(scope, key) => {
                let slot = self.slot::<T>(scope, &key, Access::Write, port)?;
                Ok(Out::new(slot, true))
            }
            // A literal has no place to write to; accepting it would lose every result.
            Binding::Literal(value) => Err(BindError::Type {
                port: port.to_owned(),
                found: format!("the literal {value}"),
                wanted: "a blackboard key to write to".to_owned(),
            }),
        }
    }

    /// A key that the node reads besides its ports, which has to be declared.
    ///
    /// # Errors
    /// [`BindError::Board`].
    pub fn reads<T: Plain>(&mut self, scope: Scope, key: &str) -> Result<In<T>, BindError> {
        Ok(In::Key(self.slot::<T>(scope, key, Access::Read, key)?))
    }

    /// A key that the node uses besides its ports, to write and read it, or only to read it,
    /// as `access` says. It is declared here with its default, unless the file declares it.
    ///
    /// # Errors
    /// [`BindError::Board`].
    pub fn writes<T: Plain>(
        &mut self,
        scope: Scope,
        key: &str,
        default: Option<T>,
        access: Access,
    ) -> Result<Out<T>, BindError> {
        let refused = |source| BindError::Board {
            port: key.to_owned(),
            source: Box::new(source),
        };
        // Declared before it is registered: a board refuses to register an unknown key.
        let default = default.map(Plain::into_value);
        self.board(scope)
            .declare(key, T::TYPE, default)
            .map_err(refused)?;
        let slot = self.slot::<T>(scope, key, access, key)?;
        Ok(Out::new(slot, access != Access::Read))
    }

    /// A text constant of the instance, `robot` for example.
    ///
    /// # Errors
    /// [`BindError::Host`] where there is none.
    pub fn text_constant(&self, name: &str) -> Result<&str, BindError> {
        match self.constants.get(name) {
            Some(Value::Text(text)) => Ok(text.as_str()),
            _ => Err(BindError::Host(format!(
                "the tree needs the text constant '{name}'; give it where the tree is used"
            ))),
        }
    }

    /// Adds a probable mistake, under a stable name `like_this`.
    pub fn warn(&mut self, rule: &'static str, message: String) {
        self.findings.push(Finding {
            rule,
            place: self.node.to_owned(),
            message,
        });
    }

    /// The value of `port` before the first write: the literal, or the default of the key it is
    /// bound to.
    pub fn initial(&self, port: &str) -> Option<Value> {
        match self.bindings.get(port)? {
            Binding::Literal(value) => Some(*value),
            Binding::Key(scope, key) => {
                let board = match scope {
                    Scope::Local => &*self.local,
                    Scope::Shared => &*self.shared,
                };
                board.keys().nth(board.index(key)?)?.default
            }
        }
    }

    fn board(&mut self, scope: Scope) -> &mut Board {
        match scope {
            Scope::Local => self.local,
            Scope::Shared => self.shared,
        }
    }

    fn binding<T: Plain>(&self, port: &str) -> Result<Binding, BindError> {
        if let Some(binding) = self.bindings.get(port) {
            return Ok(binding.clone());
        }
        // A similar bound port points to a typing error in the name; otherwise the port is
        // unbound.
        let known: Vec<&str> = self.bindings.keys().map(String::as_str).collect();
        match suggest::nearest(port, &known) {
            Some(_) => Err(BindError::Unknown {
                port: port.to_owned(),
                advice: suggest::advice(port, &known),
            }),
            None => Err(BindError::Missing {
                port: port.to_owned(),
                wanted: T::TYPE.name(),
            }),
        }
    }

    fn slot<T: Plain>(
        &mut self,
        scope: Scope,
        key: &str,
        access: Access,
        port: &str,
    ) -> Result<Slot, BindError> {
        let node = self.node;
        let index = self
            .board(scope)
            .register(node, key, T::TYPE, access)
            .map_err(|source| BindError::Board {
                port: port.to_owned(),
                source: Box::new(source),
            })?;
        Ok(Slot { scope, index })
    }
}

fn wrong_type<T: Plain>(port: &str, found: String) -> BindError {
    BindError::Type {
        port: port.to_owned(),
        found,
        wanted: T::TYPE.name().to_owned(),
    }
}
