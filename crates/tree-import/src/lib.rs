//! Behaviour trees written for BehaviorTree.CPP 4, as trees of `behavior`.
//!
//! [`import`] turns the XML of one tree with its subtrees into a file of the format
//! [`behavior::descriptor::FORMAT`]. A tree that is accepted answers the same in every tick
//! as `tickExactlyOnce` does there; a node that has no counterpart is refused with its line,
//! and all of them at once. Nodes of the author's own library become declared leaves, or uses
//! of the subtrees that provide them.
//!
//! Two differences remain. Where BehaviorTree.CPP throws an exception, because a script reads
//! a key without a value, here `==`, `<`, `>` and a key alone do not hold, and `!=`, `<=`,
//! `>=` and what `!` negates hold. And scripts there compare numbers with a tolerance of
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

/// A tree that was read, in the form in which it is used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Imported {
    /// The text of the tree file.
    pub json: String,
    /// The leaves that a program has to provide, in the order of their names.
    pub leaves: Vec<Leaf>,
    /// What the author should know.
    pub notes: Vec<String>,
}

/// A leaf that a program has to provide.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Leaf {
    /// Its type.
    pub name: String,
    /// It is never running.
    pub condition: bool,
    /// Its ports: name, type of the value, and what is done with it.
    pub ports: Vec<(String, &'static str, &'static str)>,
    /// Where it is used first.
    pub place: String,
}

/// Reads the XML of a tree. `include` reads a file by the path that is written in an
/// `<include>`, which counts from the folder of the file that it is written in. `tree` names
/// the tree to execute, where the file does not. `leaves` is a tree file whose subtrees provide
/// the leaves of their names: the tree includes it by its file name.
///
/// # Errors
/// Everything that has no counterpart or is wrong, each with file, line and column.
pub fn import(
    file: &str,
    text: &str,
    include: &dyn Fn(&str) -> Option<String>,
    tree: Option<&str>,
    leaves: Option<&Source<'_>>,
) -> Result<Imported, Errors> {
    let provided = leaves.map(provided::Provided::read).transpose()?;
    let provided = provided.unwrap_or_default();
    let project = document::read(file, text, include, tree)?;
    let translated = translate::all(&project, &provided)?;
    emit::file(&project, &translated, &provided)
}
