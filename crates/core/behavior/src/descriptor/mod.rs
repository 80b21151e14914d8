//! Trees from files.
//!
//! A file is JSON, see [`FORMAT`]: nested nodes with stable ids and typed
//! ports, and their declarations: constants, keys of the two blackboards, subtrees
//! and other files. [`load`] makes a [`Tree`] of it or reports all mistakes,
//! each with its line and column. [`check`] adds probable mistakes,
//! and [`schema()`] describes valid files for editors.
//!
//! Reading any text ends soon: sizes, depths and counts are limited. A file may come from
//! another person or be damaged, and is read by the program that also runs the cell.

pub(crate) mod advice;
mod build;
mod counterparts;
mod declared;
mod detail;
mod engine;
pub mod error;
mod files;
mod for_each;
mod foreign;
mod guards;
mod header;
pub mod json;
mod kinds;
mod leaves;
pub mod limits;
mod literal;
mod modifiers;
mod nodes;
mod ports;
mod schema;
mod signature;
mod subtrees;
mod types;

use std::collections::BTreeMap;

pub use error::{Errors, Located};
pub use files::FORMAT;
pub use schema::schema;
pub use signature::{PortSignature, Signature, signatures};

/// Names of the engine's own node types, which no leaf may have.
pub fn engine_types() -> impl Iterator<Item = &'static str> {
    engine::NODES.iter().map(|node| node.name)
}

use crate::board::{Board, Scope};
use crate::finding::Finding;
use crate::tree::{self, Host, Library, Node, Tree};
use crate::value::Value;
use declared::Declared;
use json::Location;

/// Reads a file by its name.
pub type Include<'a> = dyn Fn(&str) -> Result<String, String> + 'a;

/// A file, and the function that reads included files.
#[derive(Clone, Copy)]
pub struct Source<'a> {
    /// Its name in messages.
    pub file: &'a str,
    /// Its text.
    pub text: &'a str,
    /// Reads an included file by its name in the file, or returns why it
    /// cannot be read.
    pub include: &'a Include<'a>,
}

/// A tree after reading, before it is made ready to run.
pub struct Read<H: Host> {
    /// Name of the tree, constants replaced.
    pub name: String,
    /// Its nodes.
    pub root: Node<H>,
    /// Its local blackboard.
    pub local: Board,
    /// The shared blackboard with the keys of this tree.
    pub shared: Board,
    /// Probable mistakes, found in the text of the file.
    pub findings: Vec<Finding>,
    /// Probable mistakes that the types of its leaves added.
    pub noted: Vec<Finding>,
}

/// Reads the nodes of a file. `constants` are those of the instance; they
/// replace the file's. `shared` is not changed.
///
/// # Errors
/// All mistakes in the file and those it includes.
pub fn read<H: Host>(
    source: &Source<'_>,
    library: &Library<H>,
    constants: &BTreeMap<String, Value>,
    shared: &Board,
) -> Result<Read<H>, Errors> {
    // Nothing of a file is read if one of its includes is missing or is not JSON.
    let files = files::collect(source)?;
    let mut builder = header::read(&files, library, constants, shared, Errors::default());
    let Some(top) = files.first() else {
        return Err(builder.errors);
    };
    let (name, root) = (top.root.get("name"), top.root.get("root"));
    // Both are reported if both are missing; an included file needs neither.
    for (key, value) in [("name", name), ("root", root)] {
        if value.is_none() {
            let message = format!("\"{key}\" is missing; a tree needs it");
            builder.errors.push(&top.name, Location::START, message);
        }
    }
    let name = name.and_then(|name| builder.name(&top.name, name));
    let context = build::NodeContext {
        file: &top.name,
        prefix: String::new(),
        ports: None,
    };
    let root = root.and_then(|root| builder.node(&context, root, nodes::Seat::ROOT));
    let (Some(name), Some(root)) = (name, root) else {
        return Err(builder.errors.sorted());
    };
    finish(builder, name, root)
}

/// Makes the tree of a file. `constants` are those of the instance; they
/// replace the file's. The keys of the tree are declared and registered on `shared` if the
/// file is valid; otherwise `shared` is unchanged.
///
/// # Errors
/// All mistakes in the file and those it includes.
pub fn load<H: Host>(
    source: &Source<'_>,
    library: &Library<H>,
    constants: &BTreeMap<String, Value>,
    shared: &mut Board,
) -> Result<Tree<H>, Errors> {
    let read = read(source, library, constants, shared)?;
    grow(source.file, Location::START, read, shared)
}

/// Makes the tree of one node that is part of another kind of file.
pub(crate) fn load_node<H: Host>(
    file: &str,
    name: &str,
    root: &json::Value,
    library: &Library<H>,
    constants: &BTreeMap<String, Value>,
    shared: &mut Board,
) -> Result<Tree<H>, Errors> {
    let errors = Errors::default();
    let mut builder = build::Builder::new(library, constants.clone(), shared.clone(), errors);
    let context = build::NodeContext {
        file,
        prefix: String::new(),
        ports: None,
    };
    let Some(node) = builder.node(&context, root, nodes::Seat::ROOT) else {
        return Err(builder.errors.sorted());
    };
    let read = finish(builder, name.to_owned(), node)?;
    grow(file, root.place, read, shared)
}

fn grow<H: Host>(
    file: &str,
    place: Location,
    read: Read<H>,
    shared: &mut Board,
) -> Result<Tree<H>, Errors> {
    match Tree::new(&read.name, read.root, read.local) {
        Ok(mut tree) => {
            // The builder worked on a copy; it replaces the caller's board only when all is
            // valid.
            *shared = read.shared;
            tree.noted = read.noted;
            Ok(tree)
        }
        Err(error) => {
            let mut errors = Errors::default();
            for problem in error.problems {
                errors.push(file, place, problem.to_string());
            }
            Err(errors)
        }
    }
}

/// Probable mistakes in a file that is read without errors.
///
/// # Errors
/// As [`load`].
pub fn check<H: Host>(
    source: &Source<'_>,
    library: &Library<H>,
    constants: &BTreeMap<String, Value>,
    shared: &Board,
) -> Result<Vec<Finding>, Errors> {
    let read = read(source, library, constants, shared)?;
    let mut findings = read.findings;
    findings.extend(read.noted);
    findings.extend(tree::check::check(
        &read.root,
        &read.local,
        &read.shared,
        library,
    ));
    Ok(findings)
}

fn finish<H: Host>(
    mut builder: build::Builder<'_, H>,
    name: String,
    root: Node<H>,
) -> Result<Read<H>, Errors> {
    // With errors many declarations look unused, since their users were not read.
    if builder.errors.is_empty() {
        unused(&mut builder);
    }
    builder.errors.or(Read {
        name,
        root,
        local: builder.local,
        shared: builder.shared,
        findings: builder.findings,
        noted: builder.noted,
    })
}

/// Finds declarations without a use.
fn unused<H: Host>(builder: &mut build::Builder<'_, H>) {
    let mut found = |rule, what: &str, name: &str, file: &str, place: Location| {
        builder.findings.push(Finding {
            rule,
            place: format!("{file}:{}:{}", place.line, place.column),
            message: format!(
                "{what} '{}' is not used; take it out",
                json::shortened(name)
            ),
        });
    };
    for constant in &builder.declared_constants {
        if !builder.used_constants.contains(&constant.name) {
            let Declared { name, file, place } = constant;
            found("unused_constant", "constant", name, file, *place);
        }
    }
    for (name, subtree) in &builder.subtrees {
        if !builder.used_subtrees.contains(name) {
            found(
                "unused_subtree",
                "subtree",
                name,
                subtree.file,
                subtree.place,
            );
        }
    }
    for (scope, key) in &builder.declared_keys {
        let board = match scope {
            Scope::Local => &builder.local,
            Scope::Shared => &builder.shared,
        };
        let index = board.index(&key.name);
        if index.is_some_and(|index| board.users(index).next().is_none()) {
            let Declared { name, file, place } = key;
            found("unused_key", "blackboard key", name, file, *place);
        }
    }
}
