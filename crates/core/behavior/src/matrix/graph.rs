//! The picture of a matrix.

use super::runtime::Matrix;
use super::table::Table;
use crate::graph::{Graph, GraphEdge, GraphKind, GraphNode};
use crate::machine::{Final, StateId};

impl Table {
    /// The picture: a node for each state in the order of its id, an edge for
    /// each state to which a cell may change.
    pub fn describe(&self) -> Graph {
        let mut edges = Vec::new();
        for from in 0..self.states.len() {
            for event in &self.order {
                let Some(cell) = self.cell(StateId::of(from), *event) else {
                    continue;
                };
                let label = self.event_name(*event);
                edges.extend(cell.goto.iter().map(|to| GraphEdge {
                    from,
                    to: to.index(),
                    label: label.to_owned(),
                }));
            }
        }
        Graph {
            kind: GraphKind::Matrix,
            name: self.name.clone(),
            nodes: (0..self.states.len())
                .filter_map(|at| self.node(at))
                .collect(),
            edges,
        }
    }

    fn node(&self, at: usize) -> Option<GraphNode> {
        let state = self.states.get(at)?;
        let mut detail: Vec<String> = Vec::new();
        if let Some(during) = state.during {
            detail.push(format!("runs {}", self.behavior_name(during.run)));
        }
        // In the order of precedence, in which the events are handled.
        for event in &self.order {
            if let Some(cell) = self.cell(StateId::of(at), *event) {
                let handler = self.handler_name(cell.handler);
                detail.push(format!("{}: {handler}", self.event_name(*event)));
            }
        }
        let kind = if state.end == Final::No {
            "state"
        } else {
            "final"
        };
        Some(GraphNode {
            id: state.name.clone(),
            kind: kind.to_owned(),
            name: state.name.clone(),
            parent: None,
            detail: detail.join(", "),
        })
    }
}

impl Matrix {
    /// See [`Table::describe`]; the statuses are those of
    /// [`Matrix::statuses`].
    pub fn describe(&self) -> Graph {
        self.table().describe()
    }
}
