//! `robocell bt import`: trees of others.

use std::path::Path;

use behavior::descriptor::{Include, Source};
use cell_model::data::read_text;
use supervisor::failure::Failure;
use tree_import::{Imported, Leaf};

use crate::args::ImportArgs;
use crate::say;

/// Prints the tree of an XML file as a tree file, and on stderr the leaves to provide.
pub(crate) fn import(args: &ImportArgs) -> Result<(), Failure> {
    let file = args.file.as_path();
    let name = file.display().to_string();
    let text = read_text(file).map_err(Failure::configuration)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let include = |name: &str| read_text(&folder.join(name)).ok();
    let leaves = args.leaves.as_deref().map(Leaves::read).transpose()?;
    let leaves = leaves.as_ref().map(Leaves::source);
    let tree = args.tree.as_deref();
    let imported = tree_import::import(&name, &text, &include, tree, leaves.as_ref())
        .map_err(Failure::configuration)?;
    say::raw(imported.json.as_bytes());
    report(&imported);
    Ok(())
}

/// The file that provides leaves.
struct Leaves {
    name: String,
    text: String,
    include: Box<Include<'static>>,
}

impl Leaves {
    fn read(file: &Path) -> Result<Self, Failure> {
        let folder = file.parent().unwrap_or(Path::new("")).to_owned();
        let include =
            move |name: &str| read_text(&folder.join(name)).map_err(|error| error.to_string());
        Ok(Self {
            name: file.display().to_string(),
            text: read_text(file).map_err(Failure::configuration)?,
            include: Box::new(include),
        })
    }

    fn source(&self) -> Source<'_> {
        Source {
            file: &self.name,
            text: &self.text,
            include: &*self.include,
        }
    }
}

fn report(imported: &Imported) {
    for note in &imported.notes {
        say::warn(note);
    }
    if imported.leaves.is_empty() {
        return;
    }
    say::warn(
        "leaves to provide, with subtrees of a file (--leaves) or from Python (docs/import.md); \
         ports with the type and the access of their value:",
    );
    for leaf in &imported.leaves {
        say::warn(format_args!("  {}", line(leaf)));
    }
}

fn line(leaf: &Leaf) -> String {
    let kind = if leaf.condition {
        "condition"
    } else {
        "action"
    };
    let ports = leaf.ports.iter();
    let ports: Vec<String> = ports
        .map(|(name, value_type, access)| format!("{name} ({value_type}, {access})"))
        .collect();
    let ports = if ports.is_empty() {
        "no ports".to_owned()
    } else {
        ports.join(", ")
    };
    format!("{} ({kind}, first in {}): {ports}", leaf.name, leaf.place)
}
