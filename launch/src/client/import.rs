//! `robocell bt import`: trees of others.

use std::path::Path;

use cell_model::data::read_text;
use tree_import::{Imported, Leaf};

use crate::cli::ImportArgs;
use crate::failure::Failure;
use crate::say;

/// Prints the tree of an XML file as a tree file, and on stderr the leaves to provide.
pub(crate) fn import(args: &ImportArgs) -> Result<(), Failure> {
    let file = args.file.as_path();
    let name = file.display().to_string();
    let text = read_text(file).map_err(Failure::configuration)?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let include = |name: &str| read_text(&folder.join(name)).ok();
    let imported = tree_import::import(&name, &text, &include, args.tree.as_deref())
        .map_err(Failure::configuration)?;
    say::raw(imported.json.as_bytes());
    report(&imported);
    Ok(())
}

fn report(imported: &Imported) {
    for note in &imported.notes {
        say::warn(note);
    }
    if imported.leaves.is_empty() {
        return;
    }
    say::warn(
        "leaves that a program has to provide, a Python file for example (docs/import.md); ports \
         with the type of their value and what is done with it:",
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
