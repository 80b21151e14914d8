//! Why a tree cannot be made.

use super::{MAX_DEPTH, MAX_NODES};

/// All mistakes in a tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TreeError {
    /// Name of the tree.
    pub tree: String,
    /// The mistakes, in the order of the nodes.
    pub problems: Vec<Problem>,
}

impl std::error::Error for TreeError {}

impl std::fmt::Display for TreeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "tree '{}'", self.tree)?;
        for problem in &self.problems {
            write!(f, "\n  {problem}")?;
        }
        Ok(())
    }
}

/// A mistake in a tree.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// Two nodes with one id.
    #[error("node '{0}' is defined twice; ids are unique in a tree")]
    Duplicate(String),
    /// A wrong number of children.
    #[error("node '{id}' ({type_name}) has {found} children, {wanted} is needed")]
    Children {
        /// Id of the node.
        id: String,
        /// Its type.
        type_name: String,
        /// How many it has.
        found: usize,
        /// How many it needs.
        wanted: usize,
    },
    /// A parallel that selects a child that it does not have.
    #[error("parallel '{id}' selects child {index} of {children}; counting starts at 0")]
    Selected {
        /// Id of the node.
        id: String,
        /// The index.
        index: usize,
        /// How many children it has.
        children: usize,
    },
    /// A parallel that selects nothing.
    #[error("parallel '{0}' selects no child; name at least one")]
    NoneSelected(String),
    /// A count of zero runs.
    #[error("node '{0}' has the count 0; give it 1 or more, or none for no end")]
    Zero(String),
    /// A negative time, or one that is not finite.
    #[error("node '{id}' has a time of {seconds} s; give it 0 or more")]
    Seconds {
        /// Id of the node.
        id: String,
        /// The time as written.
        seconds: String,
    },
    /// A key that the tree's local board does not have.
    #[error("node '{0}' uses a key that the tree's blackboard does not have; declare it first")]
    Key(String),
    /// Too deep.
    #[error(
        "node '{0}' is deeper than {MAX_DEPTH} levels, modifiers included; use fewer, or split the tree"
    )]
    Deep(String),
    /// Too many.
    #[error("there are more than {MAX_NODES} nodes, modifiers included; split the tree")]
    Many,
}
