//! Pictures of behaviours: as text for terminals, and for Mermaid.
//!
//! Names come from files and may contain any characters; each view escapes them
//! for its format and keeps them on one line.

mod matrix;
mod mermaid;
mod text;

pub use matrix::matrix;
pub use mermaid::mermaid;
pub use text::text;

use crate::graph::{Graph, GraphKind, GraphNode};
use crate::status::NodeStatus;
use crate::tree::check::CONDITION;

/// Status of the node at `index`; none if there are no statuses.
fn status_of(statuses: Option<&[NodeStatus]>, index: usize) -> Option<NodeStatus> {
    Some(statuses?.get(index).copied().unwrap_or_default())
}

/// Children of each node, and the nodes without a parent. A node whose parent
/// does not come before it counts as one without, so there are no circles.
fn family(graph: &Graph) -> (Vec<usize>, Vec<Vec<usize>>) {
    let mut tops = Vec::new();
    let mut children = vec![Vec::new(); graph.nodes.len()];
    for (index, node) in graph.nodes.iter().enumerate() {
        let parent = node.parent.filter(|parent| *parent < index);
        match parent.and_then(|parent| children.get_mut(parent)) {
            Some(siblings) => siblings.push(index),
            None => tops.push(index),
        }
    }
    (tops, children)
}

/// Whether the node is a condition.
fn is_condition(graph: &Graph, node: &GraphNode) -> bool {
    let first = node.kind.split(' ').next();
    graph.kind == GraphKind::Tree && first == Some(CONDITION)
}

/// The name and, if it differs, the type.
fn caption(graph: &Graph, node: &GraphNode) -> String {
    let name = one_line(&node.name);
    let kind = one_line(&node.kind);
    let says_more = graph.kind == GraphKind::Tree && !kind.eq_ignore_ascii_case(&name);
    if says_more && !kind.is_empty() {
        format!("{name} ({kind})")
    } else {
        name
    }
}

/// Replaces control characters, which would break lines or change the terminal.
fn one_line(text: &str) -> String {
    let harmless = |c: char| if c.is_control() { ' ' } else { c };
    text.chars().map(harmless).collect()
}
