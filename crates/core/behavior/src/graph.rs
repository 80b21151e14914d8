//! One picture for all kinds of behaviour: for `show`, for the trace and for pages.

use serde::{Deserialize, Serialize};

/// The subject of a graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GraphKind {
    /// Nodes with parents; order of children is order of priority.
    Tree,
    /// States, nested by their parents, and labelled edges.
    Machine,
    /// States, and an edge for each event that changes the state.
    Matrix,
    /// Phases of code without a declared structure, drawn by its author.
    Code,
}

/// A node of a tree, or a state.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GraphNode {
    /// Stable id, unique in the graph.
    pub id: String,
    /// Type: `sequence`, `MoveToTarget`, `state`.
    pub kind: String,
    /// Name for people.
    pub name: String,
    /// Index of its parent, which comes before it.
    pub parent: Option<usize>,
    /// Ports, guards, modifiers: one line, may be empty.
    pub detail: String,
}

/// A transition from one state to another.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct GraphEdge {
    /// Index of the node it leaves.
    pub from: usize,
    /// Index of the node it enters.
    pub to: usize,
    /// Trigger and guards.
    pub label: String,
}

/// The picture. Statuses are separate from it, one per node in its order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Graph {
    /// Its subject.
    pub kind: GraphKind,
    /// Its name: of the file, of the policy, of the arm.
    pub name: String,
    /// Nodes; a parent comes before its children.
    pub nodes: Vec<GraphNode>,
    /// Edges; empty for a tree.
    pub edges: Vec<GraphEdge>,
}
