//! The picture of the stacking policies that are written as plain code: the
//! ring of phases with the edges that leave it.

use behavior::NodeStatus;
use behavior::graph::{Graph, GraphEdge, GraphKind, GraphNode};

use super::command::idle;
use super::phase::Phase;

/// Index of the state between two transfers.
const IDLE: usize = Phase::RING.len();

/// The eight phases, and the state in which the next cube is chosen.
pub fn ring(policy: &str) -> Graph {
    let node = |id: &str, detail: &str| GraphNode {
        id: id.to_owned(),
        kind: "phase".to_owned(),
        name: id.to_owned(),
        parent: None,
        detail: detail.to_owned(),
    };
    let mut nodes: Vec<GraphNode> = Phase::RING.iter().map(|p| node(p.name(), "")).collect();
    nodes.push(node(idle::HOLD, "chooses the next cube"));
    Graph {
        kind: GraphKind::Code,
        name: policy.to_owned(),
        nodes,
        edges: edges(),
    }
}

fn edges() -> Vec<GraphEdge> {
    let edge = |from: usize, to: usize, label: &str| GraphEdge {
        from,
        to,
        label: label.to_owned(),
    };
    let mut edges = vec![edge(IDLE, 0, "cube not at its goal")];
    for (from, phase) in Phase::RING.iter().enumerate() {
        let done = match phase {
            Phase::Grasp => "time",
            Phase::Release => "time and gripper open",
            _ => "settled or timeout",
        };
        edges.push(edge(from, phase.next().map_or(IDLE, |p| p as usize), done));
        if phase.holding() {
            edges.push(edge(from, IDLE, "drop"));
        }
    }
    edges.push(edge(Phase::Approach as usize, 0, "resync"));
    edges
}

/// One status for each node of [`ring`]; `phase` is `None` between transfers.
pub fn statuses(phase: Option<Phase>, out: &mut Vec<NodeStatus>) {
    let status = |active| {
        if active {
            NodeStatus::Running
        } else {
            NodeStatus::Invalid
        }
    };
    let ring = Phase::RING.into_iter();
    out.extend(ring.map(|p| status(phase == Some(p))));
    out.push(status(phase.is_none()));
}
