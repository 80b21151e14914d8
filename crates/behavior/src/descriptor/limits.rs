//! How much a file may hold, so that reading any file ends soon.

/// Files that one file may draw in, itself included.
pub const MAX_FILES: usize = 32;
/// Entries of one group: constants, keys of a blackboard, subtrees.
pub const MAX_ENTRIES: usize = 512;
/// Ports and modifiers of one node.
pub const MAX_PORTS: usize = 64;
/// Bytes of an id, a key or a name.
pub const MAX_NAME: usize = 128;
/// Bytes of a text in which constants are replaced.
pub const MAX_TEXT: usize = 1024;

pub use crate::tree::{MAX_DEPTH, MAX_NODES};
