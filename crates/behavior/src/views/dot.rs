//! For Graphviz.

use std::fmt::Write;

use super::{caption, family, is_condition, status_of};
use crate::graph::{Graph, GraphKind};
use crate::status::NodeStatus;

/// The graph for `dot`; with `statuses` its nodes are coloured. Of nested
/// states an edge from a state with others in it leaves the first of them.
pub fn dot(graph: &Graph, statuses: Option<&[NodeStatus]>) -> String {
    let mut page = String::new();
    // Writing to a text does not fail.
    let _written = draw(graph, statuses, &mut page).is_ok();
    page
}

fn draw(graph: &Graph, statuses: Option<&[NodeStatus]>, page: &mut String) -> std::fmt::Result {
    let (tops, children) = family(graph);
    let is_tree = graph.kind == GraphKind::Tree;
    writeln!(page, "digraph \"{}\" {{", escaped(&graph.name))?;
    if is_tree {
        writeln!(
            page,
            "  ordering=out;\n  node [shape=box, style=filled, fillcolor=white];"
        )?;
        for index in 0..graph.nodes.len() {
            node(graph, statuses, index, page)?;
        }
        for (index, children) in children.iter().enumerate() {
            for child in children {
                writeln!(page, "  n{index} -> n{child};")?;
            }
        }
    } else {
        writeln!(page, "  rankdir=LR; compound=true;")?;
        writeln!(
            page,
            "  node [shape=box, style=\"rounded,filled\", fillcolor=white];"
        )?;
        states(graph, statuses, (&tops, &children), page)?;
        edges(graph, &children, page)?;
    }
    writeln!(page, "}}")
}

fn node(
    graph: &Graph,
    statuses: Option<&[NodeStatus]>,
    index: usize,
    page: &mut String,
) -> std::fmt::Result {
    let Some(node) = graph.nodes.get(index) else {
        return Ok(());
    };
    let label = escaped(&caption(graph, node));
    let colour = colour(status_of(statuses, index));
    let shape = if is_condition(graph, node) {
        ", shape=hexagon"
    } else {
        ""
    };
    writeln!(page, "  n{index} [label=\"{label}\"{colour}{shape}];")
}

/// States within their parents, by a stack of their own.
fn states(
    graph: &Graph,
    statuses: Option<&[NodeStatus]>,
    (tops, children): (&[usize], &[Vec<usize>]),
    page: &mut String,
) -> std::fmt::Result {
    let mut open: Vec<Option<usize>> = tops.iter().rev().map(|top| Some(*top)).collect();
    while let Some(next) = open.pop() {
        let Some(index) = next else {
            writeln!(page, "  }}")?;
            continue;
        };
        let inner = children.get(index).map(Vec::as_slice).unwrap_or_default();
        if inner.is_empty() {
            node(graph, statuses, index, page)?;
            continue;
        }
        let name = graph.nodes.get(index).map(|node| caption(graph, node));
        let name = escaped(&name.unwrap_or_default());
        writeln!(page, "  subgraph cluster{index} {{\n  label=\"{name}\";")?;
        open.push(None);
        open.extend(inner.iter().rev().map(|child| Some(*child)));
    }
    Ok(())
}

fn edges(graph: &Graph, children: &[Vec<usize>], page: &mut String) -> std::fmt::Result {
    // An edge joins nodes, not boxes around them; it is cut at the box.
    let innermost = |mut index: usize| {
        while let Some(first) = children.get(index).and_then(|c| c.first()) {
            index = *first;
        }
        index
    };
    for edge in &graph.edges {
        if edge.from >= graph.nodes.len() || edge.to >= graph.nodes.len() {
            continue;
        }
        let (from, to) = (innermost(edge.from), innermost(edge.to));
        let label = escaped(&edge.label);
        write!(page, "  n{from} -> n{to} [label=\"{label}\"")?;
        if from != edge.from {
            write!(page, ", ltail=cluster{}", edge.from)?;
        }
        if to != edge.to {
            write!(page, ", lhead=cluster{}", edge.to)?;
        }
        writeln!(page, "];")?;
    }
    Ok(())
}

fn colour(status: Option<NodeStatus>) -> &'static str {
    match status {
        Some(NodeStatus::Running) => ", fillcolor=\"#fff3bf\"",
        Some(NodeStatus::Success) => ", fillcolor=\"#d3f9d8\"",
        Some(NodeStatus::Failure) => ", fillcolor=\"#ffe3e3\"",
        Some(NodeStatus::Halting) => ", fillcolor=\"#e5dbff\"",
        Some(NodeStatus::Invalid) | None => "",
    }
}

fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            c if c.is_control() => escaped.push(' '),
            '"' | '\\' => {
                escaped.push('\\');
                escaped.push(c);
            }
            c => escaped.push(c),
        }
    }
    escaped
}
