//! Behaviour trees.

mod binder;
pub mod check;
mod composite;
mod counting;
mod declared;
mod decorator;
mod engine;
mod error;
mod event;
mod flat;
mod flatten;
pub mod leaf;
pub mod library;
mod modifier;
mod placeholder;
mod record;
mod replace;
mod run;
pub mod spec;
mod stop;

pub use crate::board::{Carried, RecordError};
pub use binder::{BindError, Binder, Binding};
pub use declared::{DeclaredLeaf, DeclaredPort};
pub use engine::Tree;
pub use error::{Problem, TreeError};
pub use event::{Event, EventKind};
pub use flat::Counts;
pub use leaf::{AnyLeaf, Cx, Halt, Host, Leaf, any};
pub use library::{Direction, Library, NodeType, PortSpec};
pub use replace::{ReplaceError, Replacement};
pub use spec::{Abort, Kind, Memory, Modifier, Node, OneShotPolicy, ParallelPolicy, Test};

/// Largest depth of a tree; each modifier is a level.
// A tick recurses once per level, on the stack of the task.
pub const MAX_DEPTH: usize = 64;
/// Largest number of nodes of a tree; each modifier counts as one.
// The work of a tick and the size of a checkpoint are bounded by it; nodes also have 16-bit
// indices.
pub const MAX_NODES: usize = 16_384;
