//! Pictures for Mermaid.

use std::fmt::Write;

use super::{caption, family, is_condition, status_of};
use crate::graph::{Graph, GraphKind};
use crate::status::NodeStatus;

/// Names of classes, with their colours.
const CLASSES: [(&str, &str); 4] = [
    ("running", "fill:#fff3bf,stroke:#e67700"),
    ("success", "fill:#d3f9d8,stroke:#2b8a3e"),
    ("failure", "fill:#ffe3e3,stroke:#c92a2a"),
    ("halting", "fill:#e5dbff,stroke:#5f3dc4"),
];

/// The graph as a flow chart; with `statuses` its nodes are coloured.
pub fn mermaid(graph: &Graph, statuses: Option<&[NodeStatus]>) -> String {
    let mut page = String::new();
    // Writing to a text does not fail.
    let _written = draw(graph, statuses, &mut page).is_ok();
    page
}

fn draw(graph: &Graph, statuses: Option<&[NodeStatus]>, page: &mut String) -> std::fmt::Result {
    let (tops, children) = family(graph);
    let is_tree = graph.kind == GraphKind::Tree;
    writeln!(page, "flowchart {}", if is_tree { "TD" } else { "LR" })?;
    if is_tree {
        for (index, node) in graph.nodes.iter().enumerate() {
            let (open, close) = if is_condition(graph, node) {
                ("{{", "}}")
            } else {
                ("[", "]")
            };
            let caption = escaped(&caption(graph, node));
            writeln!(page, "  n{index}{open}\"{caption}\"{close}")?;
        }
        for (index, children) in children.iter().enumerate() {
            for child in children {
                writeln!(page, "  n{index} --> n{child}")?;
            }
        }
    } else {
        states(graph, &tops, &children, page)?;
        for edge in &graph.edges {
            if edge.from < graph.nodes.len() && edge.to < graph.nodes.len() {
                let (from, to, label) = (edge.from, edge.to, escaped(&edge.label));
                if label.is_empty() {
                    writeln!(page, "  n{from} --> n{to}")?;
                } else {
                    writeln!(page, "  n{from} -->|\"{label}\"| n{to}")?;
                }
            }
        }
    }
    colours(graph, statuses, page)
}

/// States within their parents, with an explicit stack.
fn states(
    graph: &Graph,
    tops: &[usize],
    children: &[Vec<usize>],
    page: &mut String,
) -> std::fmt::Result {
    // `None` ends the box of a parent.
    let mut open: Vec<Option<usize>> = tops.iter().rev().map(|top| Some(*top)).collect();
    while let Some(next) = open.pop() {
        let Some(index) = next else {
            writeln!(page, "  end")?;
            continue;
        };
        let name = graph.nodes.get(index).map(|node| caption(graph, node));
        let name = escaped(&name.unwrap_or_default());
        let inner = children.get(index).map(Vec::as_slice).unwrap_or_default();
        if inner.is_empty() {
            writeln!(page, "  n{index}([\"{name}\"])")?;
        } else {
            writeln!(page, "  subgraph n{index}[\"{name}\"]")?;
            open.push(None);
            open.extend(inner.iter().rev().map(|child| Some(*child)));
        }
    }
    Ok(())
}

fn colours(graph: &Graph, statuses: Option<&[NodeStatus]>, page: &mut String) -> std::fmt::Result {
    if statuses.is_none() {
        return Ok(());
    }
    for (class, colours) in CLASSES {
        let of_class = |index: &usize| class_of(status_of(statuses, *index)) == Some(class);
        let nodes: Vec<String> = (0..graph.nodes.len())
            .filter(of_class)
            .map(|index| format!("n{index}"))
            .collect();
        if !nodes.is_empty() {
            writeln!(page, "  classDef {class} {colours}")?;
            writeln!(page, "  class {} {class}", nodes.join(","))?;
        }
    }
    Ok(())
}

fn class_of(status: Option<NodeStatus>) -> Option<&'static str> {
    match status? {
        NodeStatus::Running => Some("running"),
        NodeStatus::Success => Some("success"),
        NodeStatus::Failure => Some("failure"),
        NodeStatus::Halting => Some("halting"),
        NodeStatus::Invalid => None,
    }
}

/// Replaces all characters that have a meaning in Mermaid or in the page around it
/// by numeric entities.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            c if c.is_control() => escaped.push(' '),
            '"' | '#' | '&' | '<' | '>' | ';' | '`' | '|' | '\\' | '%' => {
                escaped.push('#');
                escaped.push_str(&u32::from(c).to_string());
                escaped.push(';');
            }
            c => escaped.push(c),
        }
    }
    escaped
}
