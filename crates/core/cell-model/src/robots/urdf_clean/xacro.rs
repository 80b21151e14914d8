//! Distinguishes a xacro file, the template of a URDF, from a URDF.

use roxmltree::{Document, Node};

use crate::error::{Location, ModelError};

/// Elements that `xacro` removes and that have no effect alone.
const WITHOUT_EFFECT: [&str; 2] = ["property", "arg"];

/// Starts of a substitution `$(..)`.
const COMMANDS: [&str; 7] = [
    "find ", "arg ", "env ", "optenv ", "eval ", "dirname", "anon ",
];

/// Refuses a file that still has elements or values for `xacro`: their replacements are
/// missing.
///
/// # Errors
/// Returns [`ModelError::Syntax`] with the line of the first of them.
pub(super) fn refuse(file: &str, document: &Document<'_>) -> Result<(), ModelError> {
    let Some((node, found)) = document.descendants().find_map(evidence) else {
        return Ok(());
    };
    let row = document.text_pos_at(node.range().start).row;
    Err(ModelError::Syntax {
        place: Location::line(file, usize::try_from(row).ok()),
        message: format!(
            "this is a xacro file, not a URDF: it has {found}; expand it with \
             `xacro {file} > robot.urdf` and give the result"
        ),
    })
}

/// Whether `xacro` would replace a part of a value.
fn is_template(key: &str, value: &str) -> bool {
    let mut calls = value.split("$(").skip(1);
    let is_command = |call: &str| COMMANDS.iter().any(|command| call.starts_with(command));
    // Names of meshes do not matter here: meshes are left out of a URDF.
    value.contains("${") || (key != "filename" && calls.any(is_command))
}

fn evidence<'a, 'input>(node: Node<'a, 'input>) -> Option<(Node<'a, 'input>, String)> {
    let name = node.tag_name();
    let is_of_xacro = name.namespace().is_some_and(|uri| uri.contains("xacro"));
    if is_of_xacro && !WITHOUT_EFFECT.contains(&name.name()) {
        return Some((node, format!("the element 'xacro:{}'", name.name())));
    }
    let value = node
        .attributes()
        .find(|one| is_template(one.name(), one.value()))?;
    // A property that is not used may be defined by another one.
    (!is_of_xacro).then(|| (node, format!("{}=\"{}\"", value.name(), value.value())))
}
