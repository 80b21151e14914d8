//! Behaviour trees written for BehaviorTree.CPP 4, as trees of `behavior`.
//!
//! [`import`] converts the XML of one tree with its subtrees into a file of the format
//! [`behavior::descriptor::FORMAT`]. An accepted tree gives the same result in every tick
//! as `tickExactlyOnce` does there; nodes without a counterpart are refused with their lines,
//! all at once (ADR 0027). Nodes of the author's own library become declared leaves, or uses
//! of the subtrees that provide them.
//!
//! Two differences remain. Where BehaviorTree.CPP throws an exception, because a script reads
//! a key without a value, here `==`, `<`, `>` and a key alone do not hold, and `!=`, `<=`,
//! `>=` and negated ones hold. And scripts there compare numbers with a tolerance of
//! 1.2e-7, here exactly.
#![forbid(unsafe_code)]

mod bind;
mod builtin;
mod conditions;
mod decorators;
mod document;
mod emit;
mod leaves;
mod limits;
mod out;
mod provided;
mod script;
mod subtree;
mod translate;
mod types;
mod write;

pub use behavior::descriptor::{Errors, Source};

/// An imported tree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Imported {
    /// The text of the tree file.
    pub json: String,
    /// The leaves that a program has to provide, in the order of their names.
    pub leaves: Vec<Leaf>,
    /// Hints for the author.
    pub notes: Vec<String>,
}

/// A leaf that a program has to provide.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// Its type.
    pub name: String,
    /// Whether it is never running.
    pub condition: bool,
    /// Its ports: name, type of the value, and access (`read`, `write` or `both`).
    pub ports: Vec<(String, &'static str, &'static str)>,
    /// The place of its first use.
    pub place: String,
}

/// Reads the XML of a tree. `include` reads a file by the path in an `<include>`, which is
/// relative to the folder of the including file. `tree` names the tree to execute, if the
/// file does not. `leaves` is a tree file whose subtrees provide the leaves with their names:
/// the tree includes it by its file name.
///
/// # Errors
/// All nodes without a counterpart and all mistakes, each with file, line and column.
pub fn import(
    file: &str,
    text: &str,
    include: &dyn Fn(&str) -> Option<String>,
    tree: Option<&str>,
    leaves: Option<&Source<'_>>,
) -> Result<Imported, Errors> {
    // Their names decide whether a node becomes a leaf or a use of a subtree.
    let provided = leaves.map(provided::Provided::read).transpose()?;
    let provided = provided.unwrap_or_default();
    let project = document::read(file, text, include, tree)?;
    let translated = translate::all(&project, &provided)?;
    emit::file(&project, &translated, &provided)
}
