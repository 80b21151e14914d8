//! Limits of a file, so that reading any file ends soon.

/// Files that one file may include, itself counted.
// Included files may include others: without a limit a chain of them has no end.
pub const MAX_FILES: usize = 32;
/// Entries of one group: constants, keys of a blackboard, subtrees.
// Each key has a place on the board, which is part of every checkpoint.
pub const MAX_ENTRIES: usize = 512;
/// Ports and modifiers of one node.
// Uses of a subtree copy all its ports.
pub const MAX_PORTS: usize = 64;
/// Bytes of an id, a key or a name.
// A line of the trace has 160 bytes and carries the name.
pub const MAX_NAME: usize = 128;
/// Bytes of a text in which constants are replaced.
// Each constant in it may be replaced by a longer text.
pub const MAX_TEXT: usize = 1024;

pub use crate::tree::{MAX_DEPTH, MAX_NODES};
