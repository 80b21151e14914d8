//! Node types registered from Rust, for trees that are written in files.
#![allow(clippy::result_large_err, reason = "happens at load, once")]

use super::binder::{BindError, Binder};
use crate::tree::declared::MakeDeclared;
use crate::tree::leaf::{AnyLeaf, Host, Leaf, any};
use crate::value::{Plain, Value, ValueType};

/// The binding of a port, and its use by the node.
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
    /// Its purpose, with its unit.
    pub doc: &'static str,
    /// Type of its value.
    pub value_type: ValueType,
    /// Its use.
    pub direction: Direction,
    /// Value of an unbound port; without a default the port has to be bound.
    pub default: Option<Value>,
    /// Smallest and largest number allowed in a literal.
    pub range: Option<(f64, f64)>,
    /// The texts allowed in a literal; empty for any.
    pub choices: &'static [&'static str],
    /// Names of this port in files of other programs, in the same unit; not offered
    /// in new ones.
    pub aliases: &'static [&'static str],
}

impl PortSpec {
    /// Whether a file may use that name for it.
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
    /// Its effect.
    pub doc: &'static str,
    /// Words for a search.
    pub keywords: &'static [&'static str],
    /// Its ports.
    pub ports: Vec<PortSpec>,
    /// The device that its nodes drive at every tick, of which a tree has one: an arm.
    pub drives: Option<&'static str>,
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

    /// A type whose nodes store their state themselves.
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
            drives: None,
            build: Box::new(build),
        }
    }

    /// Names in older files that still mean this type.
    pub fn aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    /// Words for a search.
    pub fn keywords(mut self, keywords: &'static [&'static str]) -> Self {
        self.keywords = keywords;
        self
    }

    /// Its nodes drive `what` at every tick: two of them in one parallel are probably a
    /// mistake.
    pub fn drives(mut self, what: &'static str) -> Self {
        self.drives = Some(what);
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

    /// Literals of the last port have to be within these bounds.
    pub fn within(mut self, low: f64, high: f64) -> Self {
        if let Some(port) = self.ports.last_mut() {
            port.range = Some((low, high));
        }
        self
    }

    /// The last port accepts these texts only.
    pub fn one_of(mut self, choices: &'static [&'static str]) -> Self {
        if let Some(port) = self.ports.last_mut() {
            port.choices = choices;
        }
        self
    }

    /// The last port has other names in files of other programs.
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
        // A program may replace a type of a library that it extends.
        self.types.retain(|known| known.name != node_type.name);
        self.types.push(node_type);
        self
    }

    /// The type with that name or alias.
    pub fn find(&self, name: &str) -> Option<&NodeType<H>> {
        let called = |t: &&NodeType<H>| t.name == name || t.aliases.contains(&name);
        self.types.iter().find(called)
    }

    /// All types, in the order they were added.
    pub fn types(&self) -> &[NodeType<H>] {
        &self.types
    }
}
