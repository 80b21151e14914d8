//! Pictures for terminals.

use std::fmt::Write;

use super::{caption, family, one_line, status_of};
use crate::graph::{Graph, GraphKind};
use crate::status::NodeStatus;

/// The graph as indented lines; a tree with the kinds of its nodes and, with
/// `statuses`, their marks: `✓` success, `✗` failure, `*` running, `-` not
/// running, `~` stopping. States have `*` if they are active, and their
/// transitions below them.
pub fn text(graph: &Graph, statuses: Option<&[NodeStatus]>) -> String {
    let (tops, children) = family(graph);
    let mut page = Page {
        graph,
        statuses,
        children,
        text: String::new(),
    };
    let tops = tops.iter().rev();
    let mut open: Vec<(usize, String)> = tops.map(|top| (*top, String::new())).collect();
    // An explicit stack, since nodes may be nested deeply.
    while let Some((index, lead)) = open.pop() {
        page.node(index, &lead);
        let below = below(&lead);
        page.edges(index, &below);
        let own = page.children.get(index).cloned().unwrap_or_default();
        let count = own.len();
        // Reversed, so that the first child is on top of the stack.
        for (nth, child) in own.into_iter().enumerate().rev() {
            let branch = if nth + 1 < count {
                "├── "
            } else {
                "└── "
            };
            open.push((child, format!("{below}{branch}")));
        }
    }
    page.text
}

/// The indent of the lines below a line with the indent `indent`.
fn below(indent: &str) -> String {
    indent.replace("├── ", "│   ").replace("└── ", "    ")
}

struct Page<'a> {
    graph: &'a Graph,
    statuses: Option<&'a [NodeStatus]>,
    children: Vec<Vec<usize>>,
    text: String,
}

impl Page<'_> {
    fn node(&mut self, index: usize, lead: &str) {
        let Some(node) = self.graph.nodes.get(index) else {
            return;
        };
        let mut line = format!("{lead}{}", self.sign(&node.kind));
        line.push_str(&caption(self.graph, node));
        if !node.detail.is_empty() {
            line.push_str("  ");
            line.push_str(&one_line(&node.detail));
        }
        if let Some(mark) = self.mark(index) {
            line.push_str(mark);
        }
        self.line(&line);
    }

    fn edges(&mut self, index: usize, below: &str) {
        let has_children = self.children.get(index).is_some_and(|c| !c.is_empty());
        let rule = if has_children { "│ " } else { "  " };
        for edge in self.graph.edges.iter().filter(|e| e.from == index) {
            let to = self.graph.nodes.get(edge.to);
            let to = to.map_or_else(String::new, |node| one_line(&node.name));
            let label = one_line(&edge.label);
            self.line(&format!("{below}{rule}→ {to}: {label}"));
        }
    }

    fn line(&mut self, line: &str) {
        // Writing to a text does not fail.
        let _written = writeln!(self.text, "{}", line.trim_end()).is_ok();
    }

    /// The usual signs of behaviour trees: `→` for a sequence, `?` for a selector.
    fn sign(&self, kind: &str) -> &'static str {
        if self.graph.kind != GraphKind::Tree {
            return "";
        }
        match kind.to_lowercase().as_str() {
            "sequence" | "foreach" | "for_each" => "→ ",
            "selector" => "? ",
            "parallel" => "⇉ ",
            _ => "",
        }
    }

    fn mark(&self, index: usize) -> Option<&'static str> {
        let status = status_of(self.statuses, index)?;
        let active_only = self.graph.kind != GraphKind::Tree;
        match status {
            NodeStatus::Running => Some(" *"),
            NodeStatus::Halting => Some(" ~"),
            _ if active_only => None,
            NodeStatus::Success => Some(" ✓"),
            NodeStatus::Failure => Some(" ✗"),
            NodeStatus::Invalid => Some(" -"),
        }
    }
}
