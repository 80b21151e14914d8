//! Behaviour trees.

pub mod leaf;
pub mod library;
pub mod spec;

pub use leaf::{AnyLeaf, Cx, Halt, Host, Leaf};
pub use library::{BindError, Binder, Binding, Direction, Library, NodeType, PortSpec};
pub use spec::{Abort, Kind, Memory, Modifier, Node, OneShotPolicy, ParallelPolicy, Test};
