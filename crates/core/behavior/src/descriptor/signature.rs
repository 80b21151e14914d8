//! The interface of subtrees, for programs that write tree files.

use std::collections::BTreeMap;

use super::Source;
use super::build::Builder;
use super::declared::Subtree;
use super::error::Errors;
use super::files;
use super::header;
use super::json::Location;
use crate::board::Board;
use crate::tree::{Host, Library};
use crate::value::ValueType;

/// A subtree as a file declares it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signature {
    /// The file.
    pub file: String,
    /// Its place in the file.
    pub place: Location,
    /// Its ports, in the order in which they are declared.
    pub ports: Vec<PortSignature>,
}

/// A port of a [`Signature`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortSignature {
    /// Its name.
    pub name: String,
    /// Type of its value.
    pub value_type: ValueType,
    /// Whether it has no default, so that each use has to bind it.
    pub needed: bool,
}

/// Headers have no leaves, so any host is sufficient.
struct NoHost;

impl Host for NoHost {
    type World<'w> = ();
}

/// The subtrees that an includable file and those that it includes declare, by
/// name. Their nodes are not read.
///
/// # Errors
/// All mistakes in the declarations, a root, and a file without subtrees.
pub fn signatures(source: &Source<'_>) -> Result<BTreeMap<String, Signature>, Errors> {
    let files = files::collect(source)?;
    let (library, constants, shared) = (Library::default(), BTreeMap::new(), Board::new());
    let mut builder: Builder<'_, NoHost> =
        header::read(&files, &library, &constants, &shared, Errors::default());
    // Such a file is included by others, where a root is refused.
    if let Some(root) = files.first().and_then(|file| file.root.get("root")) {
        let message = "a file that provides leaves must not have a root; make it a subtree";
        builder.errors.push(source.file, root.place, message);
    }
    if builder.errors.is_empty() && builder.subtrees.is_empty() {
        let message = "it has no subtrees; those with the name of a leaf provide it";
        builder.errors.push(source.file, Location::START, message);
    }
    let subtrees = builder.subtrees.iter();
    let read = subtrees.map(|(name, subtree)| ((*name).to_owned(), signature(subtree)));
    let read = read.collect();
    builder.errors.or(read)
}

fn signature(subtree: &Subtree<'_>) -> Signature {
    let ports = subtree.ports.iter().map(|port| PortSignature {
        name: port.name.to_owned(),
        value_type: port.value_type,
        needed: port.default.is_none(),
    });
    Signature {
        file: subtree.file.to_owned(),
        place: subtree.place,
        ports: ports.collect(),
    }
}
