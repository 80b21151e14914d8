//! One graph of the policy, as the page shows it.

use std::collections::BTreeMap;
use std::sync::Arc;

use behavior::graph::{GraphEdge, GraphNode};
use serde_json::{Value, json};

/// One picture of the policy.
#[derive(Clone, Debug, Default)]
pub(super) struct Picture {
    pub(super) name: String,
    /// Shared with the states of the past, which are many.
    pub(super) nodes: Arc<[GraphNode]>,
    pub(super) edges: Vec<GraphEdge>,
    pub(super) letters: Vec<u8>,
    pub(super) taken: Option<GraphEdge>,
    pub(super) left: Option<usize>,
    pub(super) keys: BTreeMap<String, String>,
    pub(super) guards: BTreeMap<String, bool>,
    /// Simulated time at which each guard was sent last (s).
    pub(super) guards_sent_s: BTreeMap<String, f64>,
}

impl Picture {
    /// Kind of the picture: a tree has no edges, and the kinds of the nodes distinguish the
    /// others.
    fn kind(&self) -> &'static str {
        let is = |kind: &str| self.nodes.iter().any(|node| node.kind == kind);
        match () {
            () if is("phase") => "code",
            // Only nodes of a matrix have details with a colon.
            () if is("state") && self.nodes.iter().any(|n| n.detail.contains(": ")) => "matrix",
            () if is("state") => "machine",
            () => "tree",
        }
    }

    // Nodes arrive one per line: a picture with gaps would be drawn with wrong parents.
    pub(super) fn is_whole(&self) -> bool {
        self.nodes.iter().all(|node| !node.id.is_empty())
    }

    pub(super) fn to_json(&self) -> Value {
        json!({ "name": self.name, "kind": self.kind(), "nodes": *self.nodes, "edges": self.edges })
    }

    /// The edge taken for `reason`, the trigger or event of its label; a new one if no row
    /// leads this way.
    pub(super) fn edge_taken(&self, from: usize, to: usize, reason: &str) -> GraphEdge {
        let mut rows = self.edges.iter().filter(|e| e.from == from && e.to == to);
        let mut fired = rows.clone().filter(|e| trigger(&e.label) == reason);
        // Rows of one trigger differ in their guards, which were sent before.
        let known = fired.clone().find(|e| self.holds(&e.label));
        let known = known.or_else(|| fired.next());
        // A picture of code has no triggers.
        let has_triggers = !reason.is_empty() && self.kind() != "code";
        let passing = rows
            .clone()
            .next()
            .is_none()
            .then(|| self.passing(from, to));
        let known = known.or_else(|| rows.next().filter(|_| !has_triggers));
        let known = known.or(passing.flatten());
        known.cloned().unwrap_or_else(|| GraphEdge {
            from,
            to,
            label: reason.to_owned(),
        })
    }

    /// The edge into `to` from a state that was passed within one decision, where only one fits.
    fn passing(&self, from: usize, to: usize) -> Option<&GraphEdge> {
        let follows = |edge: &GraphEdge| {
            let mut edges = self.edges.iter();
            edges.any(|first| first.from == from && first.to == edge.from)
        };
        let mut ways = self.edges.iter().filter(|e| e.to == to && follows(e));
        let way = ways.next()?;
        ways.next().is_none().then_some(way)
    }

    /// Whether all guards of a label, `trigger [one, not other]`, held at their last
    /// evaluation.
    fn holds(&self, label: &str) -> bool {
        let guards = label.split_once(" [").map_or("", |(_, guards)| guards);
        let guards = guards.split(']').next().unwrap_or_default();
        let mut guards = guards.split(", ").filter(|guard| !guard.is_empty());
        guards.all(|guard| {
            let (name, wanted) = guard
                .strip_prefix("not ")
                .map_or((guard, true), |name| (name, false));
            self.guards.get(name) == Some(&wanted)
        })
    }
}

/// The trigger or event of an edge's label.
fn trigger(label: &str) -> &str {
    let end = label.find(" [").or_else(|| label.find(" (internal)"));
    end.and_then(|end| label.get(..end)).unwrap_or(label)
}
