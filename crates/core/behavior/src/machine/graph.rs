//! The picture of a machine.

use super::definition::Final;
use super::ids::RowId;
use super::runtime::Machine;
use super::table::{Row, Table};
use crate::graph::{Graph, GraphEdge, GraphKind, GraphNode};

impl Table {
    /// The picture: a node for each state in the order of its id, an edge for
    /// each row and source, with trigger and guards.
    pub fn describe(&self) -> Graph {
        // In the order of declaration: rows are stored by trigger and source.
        let mut rows: Vec<&Row> = self.rows.iter().collect();
        rows.sort_by_key(|row| (row.id, row.source));
        Graph {
            kind: GraphKind::Machine,
            name: self.name.clone(),
            nodes: (0..self.states.len())
                .filter_map(|at| self.node(at))
                .collect(),
            edges: rows.into_iter().map(|row| self.edge(row)).collect(),
        }
    }

    fn node(&self, at: usize) -> Option<GraphNode> {
        let state = self.states.get(at)?;
        let kind = match (state.end, state.parallel) {
            (Final::No, false) => "state",
            (Final::No, true) => "parallel",
            (Final::Success, _) => "final",
            (Final::Failure, _) => "final_failure",
        };
        let runs = state.during.map(|during| self.behavior_name(during.run));
        let own = state.name.rsplit('.').next().unwrap_or_default();
        Some(GraphNode {
            id: state.name.clone(),
            kind: kind.to_owned(),
            name: own.to_owned(),
            parent: state.parent.map(super::ids::StateId::index),
            detail: runs.map(|name| format!("runs {name}")).unwrap_or_default(),
        })
    }

    fn edge(&self, row: &Row) -> GraphEdge {
        let mut label = self.trigger_name(row.trigger).to_owned();
        let guards = self.guards_of(row);
        // The guards are part of the label, since rows with the same trigger differ by them
        // only.
        if !guards.is_empty() {
            label = format!("{label} [{guards}]");
        }
        if row.dest.is_none() {
            label.push_str(" (internal)");
        }
        GraphEdge {
            from: row.source.index(),
            to: row.dest.unwrap_or(row.source).index(),
            label,
        }
    }

    /// `a, not b`.
    pub(super) fn guards_of(&self, row: &Row) -> String {
        let conditions = row.conditions.of(&self.conditions).iter();
        let words: Vec<String> = conditions
            .map(|condition| {
                let not = if condition.expected { "" } else { "not " };
                format!("{not}{}", self.guard_name(condition.guard))
            })
            .collect();
        words.join(", ")
    }

    /// The name of a row in messages: its number among the rows, from 1, and its
    /// line in the file.
    pub fn row_name(&self, row: RowId) -> String {
        match self.row_lines.get(row.index()) {
            // Line 0 is a row written in Rust.
            None | Some(0) => format!("row {}", row.index() + 1),
            Some(line) => format!("row {} (line {line})", row.index() + 1),
        }
    }
}

impl Machine {
    /// See [`Table::describe`]; the statuses are those of
    /// [`Machine::statuses`].
    pub fn describe(&self) -> Graph {
        self.table.describe()
    }
}
