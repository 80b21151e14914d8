//! What the task says about itself, put together again from its trace.

use std::collections::{BTreeSet, VecDeque};

use behavior::NodeStatus;
use behavior::graph::{Graph, GraphEdge, GraphKind, GraphNode};
use ipc_types::TraceLine;
use ipc_types::trace::{FIELD_END, TraceKind};

/// Lines of the log that are kept.
const KEPT_LINES: usize = 200;
/// Most pictures, and nodes and edges of one: more than any policy that loads has, except
/// for edges.
const MAX_GRAPHS: usize = 16;
const MAX_NODES: usize = 16_384;
const MAX_EDGES: usize = 4096;

/// One picture of the policy, with the statuses of its nodes.
pub(crate) struct Watched {
    pub(crate) graph: Graph,
    pub(crate) statuses: Vec<NodeStatus>,
    /// Whether a status was heard.
    heard: bool,
}

/// The trace of a task, as far as it was heard.
#[derive(Default)]
pub(crate) struct Trace {
    pub(crate) pictures: Vec<Watched>,
    /// Newest last: simulated seconds and text.
    pub(crate) log: VecDeque<(f64, String)>,
    /// Whether it was said that a picture is larger than is shown.
    said_large: bool,
}

impl Trace {
    /// Takes one line; what makes no sense is left out.
    pub(crate) fn take(&mut self, line: &TraceLine) {
        let (graph, node) = (line.graph as usize, line.node as usize);
        let text = line.text.as_str();
        match TraceKind::from_code(line.kind) {
            Some(TraceKind::Log | TraceKind::Transition | TraceKind::Lifecycle) => {
                let time_s = line.header.sim_time_ns as f64 * 1.0e-9;
                self.say(time_s, text.to_owned());
            }
            Some(TraceKind::Node) => self.node(graph, node, line, text),
            Some(TraceKind::Edge) => self.edge(graph, line, text),
            Some(TraceKind::Status) => {
                let status = STATUSES.get(line.to as usize).copied();
                self.status(graph, node, status.unwrap_or_default());
            }
            Some(TraceKind::Statuses) => {
                for (offset, letter) in text.chars().enumerate() {
                    let status = NodeStatus::from_letter(letter).unwrap_or_default();
                    self.status(graph, node + offset, status);
                }
            }
            Some(TraceKind::Guard | TraceKind::Key) | None => {}
        }
    }

    /// Adds a line to the log: simulated seconds and text.
    pub(crate) fn say(&mut self, time_s: f64, text: String) {
        self.log.push_back((time_s, text));
        while self.log.len() > KEPT_LINES {
            self.log.pop_front();
        }
    }

    fn status(&mut self, graph: usize, node: usize, status: NodeStatus) {
        let picture = self.pictures.get_mut(graph);
        if let Some(picture) = picture
            && let Some(slot) = picture.statuses.get_mut(node)
        {
            *slot = status;
            picture.heard = true;
        }
    }

    fn node(&mut self, graph: usize, node: usize, line: &TraceLine, text: &str) {
        let count = line.to as usize;
        if graph >= MAX_GRAPHS || count > MAX_NODES {
            return self.exceed(line);
        }
        if node >= count {
            return;
        }
        while self.pictures.len() <= graph {
            self.pictures.push(Watched {
                graph: Graph {
                    kind: GraphKind::Tree,
                    name: String::new(),
                    nodes: Vec::new(),
                    edges: Vec::new(),
                },
                statuses: Vec::new(),
                heard: false,
            });
        }
        let Some(picture) = self.pictures.get_mut(graph) else {
            return;
        };
        if node == 0 {
            // The picture restarts, perhaps another one.
            picture.graph.kind = GraphKind::Tree;
            picture.graph.edges.clear();
        }
        picture.statuses.resize(count, NodeStatus::Invalid);
        picture.graph.nodes.resize_with(count, unseen);
        let mut fields = text.split(FIELD_END).map(str::to_owned);
        let mut field = || fields.next().unwrap_or_default();
        picture.graph.name = field();
        if let Some(slot) = picture.graph.nodes.get_mut(node) {
            *slot = GraphNode {
                id: field(),
                kind: field(),
                name: field(),
                // A parent has a smaller index: a line that says otherwise could make a loop of
                // parents.
                parent: (line.from as usize).checked_sub(1).filter(|p| *p < node),
                detail: field(),
            };
        }
    }

    fn edge(&mut self, graph: usize, line: &TraceLine, text: &str) {
        let Some(picture) = self.pictures.get_mut(graph) else {
            return;
        };
        let edge = GraphEdge {
            from: line.from as usize,
            to: line.to as usize,
            label: text.to_owned(),
        };
        let nodes = picture.graph.nodes.len();
        let fits = edge.from < nodes && edge.to < nodes;
        // The task repeats its pictures: where the first line of one is lost, its edges are here
        // already.
        if !fits || picture.graph.edges.contains(&edge) {
            return;
        }
        if picture.graph.edges.len() == MAX_EDGES {
            return self.exceed(line);
        }
        // The trace does not carry the kind: a picture with edges is drawn as a machine.
        picture.graph.kind = GraphKind::Machine;
        picture.graph.edges.push(edge);
    }

    /// Reports once that a picture is larger than is shown.
    fn exceed(&mut self, line: &TraceLine) {
        if !std::mem::replace(&mut self.said_large, true) {
            let text = format!(
                "the task has more than {MAX_GRAPHS} graphs, or one with more than {MAX_NODES} \
                 nodes or {MAX_EDGES} edges: not all are shown"
            );
            self.say(line.header.sim_time_ns as f64 * 1.0e-9, text);
        }
    }

    /// `lines` of the trace were not read in time, up to simulated time `time_s`.
    pub(crate) fn missed(&mut self, time_s: f64, lines: u64) {
        self.say(
            time_s,
            format!("{lines} lines of the task were not read in time"),
        );
    }

    /// Whether there is a picture, and each is whole.
    pub(crate) fn is_complete(&self) -> bool {
        !self.pictures.is_empty() && self.pictures.iter().all(Watched::is_complete)
    }

    /// Whether it was heard of each picture what its nodes do.
    pub(crate) fn has_statuses(&self) -> bool {
        self.pictures.iter().all(|picture| picture.heard)
    }

    /// Names of the nodes at work: the running ones that no running one is part
    /// of, of each picture.
    pub(crate) fn active(&self) -> Vec<String> {
        self.pictures.iter().map(Watched::active).collect()
    }
}

impl Watched {
    /// Whether every node was received. A reader that joins in the middle of a picture has a
    /// part of it until the next one.
    pub(crate) fn is_complete(&self) -> bool {
        self.graph.nodes.iter().all(|node| !node.kind.is_empty())
    }

    /// Whether it shows a matrix: only its states name handlers by event.
    pub(crate) fn is_matrix(&self) -> bool {
        let mut nodes = self.graph.nodes.iter();
        nodes.any(|node| node.kind == "state" && node.detail.contains(": "))
    }

    fn active(&self) -> String {
        let runs = |node: usize| self.statuses.get(node) == Some(&NodeStatus::Running);
        let running = || {
            self.graph
                .nodes
                .iter()
                .enumerate()
                .filter(|(n, _)| runs(*n))
        };
        let parents: BTreeSet<usize> = running().filter_map(|(_, n)| n.parent).collect();
        let tips: Vec<&str> = running()
            .filter(|(node, _)| !parents.contains(node))
            .map(|(_, n)| n.name.as_str())
            .collect();
        tips.join(", ")
    }
}

/// Statuses by number on the wire.
const STATUSES: [NodeStatus; 5] = [
    NodeStatus::Invalid,
    NodeStatus::Running,
    NodeStatus::Success,
    NodeStatus::Failure,
    NodeStatus::Halting,
];

fn unseen() -> GraphNode {
    GraphNode {
        id: String::new(),
        kind: String::new(),
        name: String::new(),
        parent: None,
        detail: String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::{Text, Wire};

    fn line(kind: TraceKind, node: u32, from: u32, to: u32, text: &str) -> TraceLine {
        let mut line = TraceLine::zeroed();
        line.kind = kind.code();
        (line.node, line.from, line.to) = (node, from, to);
        line.text = Text::new(text);
        line
    }

    #[test]
    fn a_tree_is_put_together_and_its_tip_named() {
        let mut trace = Trace::default();
        trace.take(&line(
            TraceKind::Node,
            0,
            0,
            2,
            "bt\u{1f}root\u{1f}selector\u{1f}Root\u{1f}",
        ));
        trace.take(&line(
            TraceKind::Node,
            1,
            1,
            2,
            "bt\u{1f}lift\u{1f}action\u{1f}Lift\u{1f}LIFT",
        ));
        assert!(trace.is_complete() && !trace.has_statuses());
        trace.take(&line(TraceKind::Statuses, 0, 0, 0, "RR"));
        assert!(trace.has_statuses());
        assert_eq!(trace.active(), ["Lift"]);
        trace.take(&line(TraceKind::Status, 1, 1, 2, ""));
        assert_eq!(trace.active(), ["Root"]);
    }

    #[test]
    fn a_picture_heard_from_its_middle_on_is_not_complete() {
        let node = |node, name: &str| {
            let text = format!("bt\u{1f}{name}\u{1f}action\u{1f}{name}\u{1f}");
            line(TraceKind::Node, node, node, 2, &text)
        };
        let mut trace = Trace::default();
        assert!(!trace.is_complete(), "nothing was heard");
        trace.take(&node(1, "lift"));
        assert!(!trace.is_complete(), "the root was not heard");
        trace.take(&node(0, "root"));
        assert!(trace.is_complete());
    }

    #[test]
    fn nonsense_is_left_out() {
        let mut trace = Trace::default();
        trace.take(&line(TraceKind::Node, 7, 0, 3, "x"));
        trace.take(&line(TraceKind::Node, 0, 0, u32::MAX, "x"));
        trace.take(&line(TraceKind::Status, 9, 9, 9, "x"));
        trace.take(&line(TraceKind::Edge, 0, 1, 2, "x"));
        assert!(trace.pictures.is_empty());
    }
}
