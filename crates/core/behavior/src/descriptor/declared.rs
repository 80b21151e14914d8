//! The declarations in the header of a tree file.

use super::json::{Location, Value as Json};
use crate::value::ValueType;

/// The two boards.
pub(super) const SCOPES: &[&str] = &["local", "shared"];

/// A declaration and its place.
pub(super) struct Declared<'a> {
    pub name: String,
    pub file: &'a str,
    pub place: Location,
}

/// A port of a subtree.
pub(super) struct SubtreePort<'a> {
    pub name: &'a str,
    pub value_type: ValueType,
    pub default: Option<&'a Json>,
}

/// A subtree before it is used.
pub(super) struct Subtree<'a> {
    pub file: &'a str,
    pub place: Location,
    pub ports: Vec<SubtreePort<'a>>,
    pub root: &'a Json,
}
