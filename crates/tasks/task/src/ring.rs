//! The picture of a policy in plain code: a ring of its phases.

use behavior::NodeStatus;
use behavior::graph::{Graph, GraphEdge, GraphKind, GraphNode};

/// A ring of `phases`; of a policy without any, one node with its name.
pub fn graph(name: &str, phases: &[&str]) -> Graph {
    let names = if phases.is_empty() { &[name] } else { phases };
    let nodes = names.iter().map(|phase| node(phase, "")).collect();
    let next = |from: usize| (from + 1) % names.len();
    // A single node gets no edge to itself.
    let count = if names.len() > 1 { names.len() } else { 0 };
    let edges = (0..count).map(|from| edge(from, next(from), ""));
    Graph {
        kind: GraphKind::Code,
        name: name.to_owned(),
        nodes,
        edges: edges.collect(),
    }
}

/// Appends a status for each node of [`graph`]: the active phase runs.
pub fn statuses(phases: &[&str], active: &str, out: &mut Vec<NodeStatus>) {
    if phases.is_empty() {
        out.push(NodeStatus::Running);
    }
    out.extend(phases.iter().map(|phase| running_if(*phase == active)));
}

/// A phase as a node; `detail` is an additional description.
pub fn node(phase: &str, detail: &str) -> GraphNode {
    GraphNode {
        id: phase.to_owned(),
        kind: "phase".to_owned(),
        name: phase.to_owned(),
        parent: None,
        detail: detail.to_owned(),
    }
}

/// An edge between two nodes, by their indices.
pub fn edge(from: usize, to: usize, label: &str) -> GraphEdge {
    GraphEdge {
        from,
        to,
        label: label.to_owned(),
    }
}

/// The status of a phase.
pub fn running_if(active: bool) -> NodeStatus {
    if active {
        NodeStatus::Running
    } else {
        NodeStatus::Invalid
    }
}
