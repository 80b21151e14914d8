//! The pictures of a policy, and the statuses of their nodes, as trace lines.

use std::ops::Range;

use behavior::NodeStatus;
use behavior::graph::{Graph, GraphEdge, GraphKind};
use ipc_types::Text;
use ipc_types::trace::{FIELD_END, LINE_BYTES, TraceEvent, TraceKind};

use crate::output::{Output, TraceLineText};
use crate::policy::AnyPolicy;

/// Remembers the statuses of the nodes in order to report changes.
pub struct Tracer {
    graphs: Vec<Graph>,
    shown: Vec<Vec<NodeStatus>>,
    now: Vec<NodeStatus>,
}

impl Tracer {
    /// For a policy that keeps its pictures.
    pub fn new(policy: &dyn AnyPolicy, name: &str) -> Self {
        let graphs = policy.describe(name);
        let nodes = graphs.iter().map(|g| g.nodes.len());
        // Room for the largest picture: statuses are collected ten times a second without an
        // allocation.
        let most = nodes.clone().max().unwrap_or(0);
        Self {
            shown: nodes.map(|n| vec![NodeStatus::Invalid; n]).collect(),
            now: Vec::with_capacity(most),
            graphs,
        }
    }

    /// The pictures.
    pub fn graphs(&self) -> &[Graph] {
        &self.graphs
    }

    /// Takes the statuses of a restored policy as reported. They are not changes: a
    /// breakpoint must not be reached by a phase that continues.
    pub(crate) fn resume(&mut self, policy: &dyn AnyPolicy) {
        for (graph, shown) in self.shown.iter_mut().enumerate() {
            self.now.clear();
            policy.statuses(graph, &mut self.now);
            for (before, now) in shown.iter_mut().zip(&self.now) {
                *before = *now;
            }
        }
    }

    /// Reports phase changes of policies in plain code; engines report their changes
    /// themselves, with the reason.
    pub fn changes(&mut self, policy: &dyn AnyPolicy, out: &mut Output) {
        let pictures = self.graphs.iter().zip(&mut self.shown).enumerate();
        for (index, (graph, shown)) in pictures {
            if graph.kind != GraphKind::Code {
                continue;
            }
            self.now.clear();
            policy.statuses(index, &mut self.now);
            // The phase that is left comes before the one that is entered, in any order of
            // their numbers: a reader takes the two for one transition.
            for enters in [false, true] {
                for (node, (before, after)) in shown.iter_mut().zip(&self.now).enumerate() {
                    if before != after && (*after == NodeStatus::Running) == enters {
                        out.status((index, node), *before, *after, "phase");
                        *before = *after;
                    }
                }
            }
        }
    }

    /// Appends all node statuses.
    pub fn statuses(&mut self, policy: &dyn AnyPolicy, lines: &mut Vec<TraceLineText>) {
        for graph in 0..self.graphs.len() {
            self.now.clear();
            policy.statuses(graph, &mut self.now);
            // One letter per node: a line of the trace carries the statuses of 160 nodes, where
            // a line per node and tenth of a second would fill the buffer of 1024 lines (ADR
            // 0009).
            for (chunk, statuses) in self.now.chunks(LINE_BYTES).enumerate() {
                let mut letters = [0; LINE_BYTES];
                for (slot, status) in letters.iter_mut().zip(statuses) {
                    *slot = u8::try_from(status.letter()).unwrap_or(b'-');
                }
                let text = letters.get(..statuses.len()).unwrap_or_default();
                let text = std::str::from_utf8(text).unwrap_or_default();
                let mut line = line(TraceKind::Statuses, graph, text);
                // Index of the first node of this line, so that a lost line shifts no other
                // one.
                line.node = chunk * LINE_BYTES;
                lines.push(line);
            }
        }
    }

    /// Number of lines of the pictures.
    pub fn picture_lines(&self) -> usize {
        let lines = self.graphs.iter().map(|g| g.nodes.len() + g.edges.len());
        lines.sum()
    }

    /// Appends those lines of the pictures: all nodes of a graph, then its edges.
    pub fn pictures(&self, range: Range<usize>, lines: &mut Vec<TraceLineText>) {
        let all = self.graphs.iter().enumerate().flat_map(|(index, graph)| {
            let nodes = (0..graph.nodes.len()).map(move |node| (index, graph, Part::Node(node)));
            let edges = graph.edges.iter();
            nodes.chain(edges.map(move |edge| (index, graph, Part::Edge(edge))))
        });
        let wanted = all.skip(range.start).take(range.len());
        lines.extend(wanted.filter_map(|(index, graph, part)| match part {
            Part::Node(node) => node_line(index, graph, node),
            Part::Edge(edge) => Some(edge_line(index, edge)),
        }));
    }
}

/// Part of a picture that has one line.
enum Part<'a> {
    Node(usize),
    Edge(&'a GraphEdge),
}

fn node_line(index: usize, graph: &Graph, node: usize) -> Option<TraceLineText> {
    let spec = graph.nodes.get(node)?;
    // The detail is last, since the end of a long line is cut.
    let text = format!(
        "{}{FIELD_END}{}{FIELD_END}{}{FIELD_END}{}{FIELD_END}{}",
        graph.name, spec.id, spec.kind, spec.name, spec.detail
    );
    let mut line = line(TraceKind::Node, index, &text);
    line.node = node;
    // 0 means "no parent" in a message, so indices of parents count from 1.
    line.from = spec.parent.map_or(0, |p| number(p + 1));
    line.to = number(graph.nodes.len());
    Some(line)
}

fn edge_line(index: usize, edge: &GraphEdge) -> TraceLineText {
    let mut line = line(TraceKind::Edge, index, &edge.label);
    line.from = number(edge.from);
    line.to = number(edge.to);
    line
}

fn number(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

fn line(kind: TraceKind, graph: usize, text: &str) -> TraceLineText {
    TraceLineText {
        kind,
        graph,
        node: 0,
        from: 0,
        to: 0,
        event: TraceEvent::None,
        text: Text::new(text),
    }
}
