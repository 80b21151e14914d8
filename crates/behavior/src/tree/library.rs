//! Node types registered from Rust, for trees that are written in files.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

use std::collections::BTreeMap;

use crate::board::{Access, Board, BoardError, In, Out, Scope, Slot};
use crate::suggest;
use crate::tree::declared::MakeDeclared;
use crate::tree::leaf::{AnyLeaf, Host, Leaf, any};
use crate::value::{Plain, Value, ValueType};

/// What a port may be bound to, and what the node does with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// A literal or a key that is read.
    In,
    /// A key that is written.
    Out,
}

/// A port as declared.
#[derive(Clone, Debug, PartialEq)]
pub struct PortSpec {
    /// Its name.
    pub name: &'static str,
    /// What it is for, with its unit.
    pub doc: &'static str,
    /// Type of its value.
    pub value_type: ValueType,
    /// What is done with it.
    pub direction: Direction,
    /// Value where it is not bound; without one it has to be.
    pub default: Option<Value>,
    /// Smallest and largest number allowed in a literal.
    pub range: Option<(f64, f64)>,
    /// The texts allowed in a literal; empty for any.
    pub choices: &'static [&'static str],
    /// Names in files of others that mean this port, in the same unit; not offered
    /// in new ones.
    pub aliases: &'static [&'static str],
}

impl PortSpec {
    /// Whether a file may call it so.
    pub fn is_called(&self, name: &str) -> bool {
        self.name == name || self.aliases.contains(&name)
    }
}

type Build<H> =
    Box<dyn Fn(&mut Binder<'_>) -> Result<Box<dyn AnyLeaf<H>>, BindError> + Send + Sync>;

/// A type of node that a file can name.
pub struct NodeType<H: Host> {
    /// Name in files.
    pub name: &'static str,
    /// Names in older files, not offered in new ones.
    pub aliases: &'static [&'static str],
    /// What it does.
    pub doc: &'static str,
    /// Words to find it by.
    pub keywords: &'static [&'static str],
    /// Its ports.
    pub ports: Vec<PortSpec>,
    #[allow(dead_code, reason = "called by the descriptor")]
    pub(crate) build: Build<H>,
}

impl<H: Host> NodeType<H> {
    /// A type whose nodes are made by `build` from their bound ports.
    pub fn new<L: Leaf<H>>(
        name: &'static str,
        doc: &'static str,
        build: impl Fn(&mut Binder<'_>) -> Result<L, BindError> + Send + Sync + 'static,
    ) -> Self {
        Self::any(name, doc, move |binder| Ok(any(build(binder)?)))
    }

    /// A type whose nodes keep their state themselves.
    pub fn any(
        name: &'static str,
        doc: &'static str,
        build: impl Fn(&mut Binder<'_>) -> Result<Box<dyn AnyLeaf<H>>, BindError>
        + Send
        + Sync
        + 'static,
    ) -> Self {
        Self {
            name,
            aliases: &[],
            doc,
            keywords: &[],
            ports: Vec::new(),
            build: Box::new(build),
        }
    }

    /// Names of older files that still mean this type.
    pub fn aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    /// Words to find it by.
    pub fn keywords(mut self, keywords: &'static [&'static str]) -> Self {
        self.keywords = keywords;
        self
    }

    /// With an input that has to be bound.
    pub fn input<T: Plain>(self, name: &'static str, doc: &'static str) -> Self {
        self.port(name, doc, T::TYPE, Direction::In, None)
    }

    /// With an input that has a default.
    pub fn input_or<T: Plain>(self, name: &'static str, default: T, doc: &'static str) -> Self {
        let default = Some(default.into_value());
        self.port(name, doc, T::TYPE, Direction::In, default)
    }

    /// With an output.
    pub fn output<T: Plain>(self, name: &'static str, doc: &'static str) -> Self {
        self.port(name, doc, T::TYPE, Direction::Out, None)
    }

    /// The last port takes literals within these bounds only.
    pub fn within(mut self, low: f64, high: f64) -> Self {
        if let Some(port) = self.ports.last_mut() {
            port.range = Some((low, high));
        }
        self
    }

    /// The last port takes these texts only.
    pub fn one_of(mut self, choices: &'static [&'static str]) -> Self {
        if let Some(port) = self.ports.last_mut() {
            port.choices = choices;
        }
        self
    }

    /// The last port has other names in files of others.
    pub fn also(mut self, aliases: &'static [&'static str]) -> Self {
        if let Some(port) = self.ports.last_mut() {
            port.aliases = aliases;
        }
        self
    }

    fn port(
        mut self,
        name: &'static str,
        doc: &'static str,
        value_type: ValueType,
        direction: Direction,
        default: Option<Value>,
    ) -> Self {
        self.ports.push(PortSpec {
            name,
            doc,
            value_type,
            direction,
            default,
            range: None,
            choices: &[],
            aliases: &[],
        });
        self
    }
}

/// The node types a file may name, besides the engine's own.
pub struct Library<H: Host> {
    types: Vec<NodeType<H>>,
    /// Makes leaves of types that a file declares.
    pub(crate) declared: Option<MakeDeclared<H>>,
}

impl<H: Host> Default for Library<H> {
    fn default() -> Self {
        Self {
            types: Vec::new(),
            declared: None,
        }
    }
}

impl<H: Host> Library<H> {
    /// Adds a type; of two with one name the later is used.
    pub fn with(mut self, node_type: NodeType<H>) -> Self {
        self.types.retain(|known| known.name != node_type.name);
        self.types.push(node_type);
        self
    }

    /// The type of that name or alias.
    pub fn find(&self, name: &str) -> Option<&NodeType<H>> {
        let called = |t: &&NodeType<H>| t.name == name || t.aliases.contains(&name);
        self.types.iter().find(called)
    }

    /// All types, in the order they were added.
    pub fn types(&self) -> &[NodeType<H>] {
        &self.types
    }
}

/// What a port of a node was bound to in the file.
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
    #[error("there is no port '{port}'; {advice}")]
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
        /// What it was bound to.
        found: String,
        /// What is needed.
        wanted: String,
    },
    /// The board.
    #[error("port '{port}': {source}")]
    Board {
        /// The port or key.
        port: String,
        /// What it said.
        source: Box<BoardError>,
    },
    /// A name from the host's world that is not there.
    #[error("{0}")]
    Host(String),
}

/// Hands a node the ports it was bound to, registering every key it uses.
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
    /// [`BindError`] where it is missing, a literal, or not to be written.
    pub fn output<T: Plain>(&mut self, port: &str) -> Result<Out<T>, BindError> {
        match self.binding::<T>(port)? {
            Binding::Key(scope, key) => {
                let slot = self.slot::<T>(scope, &key, Access::Write, port)?;
                Ok(Out::new(slot, true))
            }
            Binding::Literal(value) => Err(BindError::Type {
                port: port.to_owned(),
                found: format!("the literal {value}"),
                wanted: "a blackboard key to write to".to_owned(),
            }),
        }
    }

    /// A key the node reads besides its ports, which has to be declared.
    ///
    /// # Errors
    /// [`BindError::Board`].
    pub fn reads<T: Plain>(&mut self, scope: Scope, key: &str) -> Result<In<T>, BindError> {
        Ok(In::Key(self.slot::<T>(scope, key, Access::Read, key)?))
    }

    /// A key the node uses besides its ports, to write and to read, or only to
    /// read, as `access` says. It is declared here with its default, unless the
    /// file did.
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
