//! A matrix for terminals, as a table.

use super::{one_line, status_of};
use crate::graph::{Graph, GraphNode};
use crate::status::NodeStatus;

/// The gap between two columns.
const GAP: &str = "  ";
/// The prefix of the sub-behaviour in the detail of a state.
const RUNS: &str = "runs ";
/// Marks an active state.
const ACTIVE: &str = " *";

/// The graph of a matrix as a table of at most `width` characters, if its cells allow it: a
/// row for each event and a column for each state, or the transposed table if only that
/// fits. If neither does, the columns are continued in tables below. A cell names its
/// handler and, below it, the states to which it may change. With `statuses` the active
/// state has `*`.
pub fn matrix(graph: &Graph, statuses: Option<&[NodeStatus]>, width: usize) -> String {
    let by_event = Table::of(graph, statuses);
    if by_event.width() <= width {
        return by_event.text();
    }
    let by_state = by_event.turned();
    if by_state.width() <= width {
        return by_state.text();
    }
    let parts: Vec<String> = by_event.parts(width).iter().map(Table::text).collect();
    parts.join("\n")
}

/// Lines of a cell.
type Cell = Vec<String>;

struct Table {
    columns: Vec<String>,
    /// Name and cells.
    rows: Vec<(String, Vec<Cell>)>,
}

impl Table {
    /// A row for each event, a column for each state.
    fn of(graph: &Graph, statuses: Option<&[NodeStatus]>) -> Self {
        let known: Vec<Vec<(String, String)>> = graph.nodes.iter().map(handlers).collect();
        let name = |(index, node): (usize, &GraphNode)| {
            let is_active = status_of(statuses, index) == Some(NodeStatus::Running);
            let mark = if is_active { ACTIVE } else { "" };
            format!("{}{mark}", one_line(&node.name))
        };
        let cell = |state: usize, event: &str| {
            let handler = known.get(state)?.iter().find(|(of, _)| of == event);
            let goes = graph.edges.iter();
            let goes = goes.filter(|edge| edge.from == state && edge.label == event);
            let goes = goes.filter_map(|edge| graph.nodes.get(edge.to));
            let goes: Vec<String> = goes.map(|node| one_line(&node.name)).collect();
            let mut lines = vec![one_line(&handler?.1)];
            if !goes.is_empty() {
                lines.push(format!("→ {}", goes.join(" | ")));
            }
            Some(lines)
        };
        let states = 0..graph.nodes.len();
        let row = |event: String| {
            let cells = states.clone().map(|state| cell(state, &event));
            let cells = cells.map(Option::unwrap_or_default).collect();
            (one_line(&event), cells)
        };
        Self {
            columns: graph.nodes.iter().enumerate().map(name).collect(),
            rows: order(&known).into_iter().map(row).collect(),
        }
    }

    /// The transposed table.
    fn turned(&self) -> Self {
        let column = |at: usize| {
            let cells = self.rows.iter().map(move |(_, cells)| cells.get(at));
            cells
                .map(|cell| cell.cloned().unwrap_or_default())
                .collect()
        };
        let rows = self.columns.iter().enumerate();
        Self {
            columns: self.rows.iter().map(|(name, _)| name.clone()).collect(),
            rows: rows.map(|(at, name)| (name.clone(), column(at))).collect(),
        }
    }

    /// The same rows, with the columns in several tables.
    fn parts(&self, width: usize) -> Vec<Self> {
        let (mut parts, mut from) = (Vec::new(), 0);
        while from < self.columns.len() {
            // The largest number of columns that fits, so that there are few tables.
            let fits = |to: &usize| self.part(from, *to).width() <= width;
            let to = (from + 1..=self.columns.len()).rev().find(fits);
            // A column that is too wide by itself is shown anyway.
            let to = to.unwrap_or(from + 1);
            parts.push(self.part(from, to));
            from = to;
        }
        parts
    }

    fn part(&self, from: usize, to: usize) -> Self {
        let rows = self.rows.iter().map(|(name, cells)| {
            let cells = cells.get(from..to).unwrap_or_default();
            (name.clone(), cells.to_vec())
        });
        Self {
            columns: self.columns.get(from..to).unwrap_or_default().to_vec(),
            rows: rows.collect(),
        }
    }

    /// Width of the names of the rows, then of each column (characters).
    fn widths(&self) -> Vec<usize> {
        let length = |text: &String| text.chars().count();
        let names = self.rows.iter().map(|(name, _)| length(name)).max();
        let column = |(at, title): (usize, &String)| {
            let cells = self.rows.iter().filter_map(|(_, cells)| cells.get(at));
            let widest = cells.flatten().map(length).max().unwrap_or(0);
            widest.max(length(title))
        };
        let columns = self.columns.iter().enumerate().map(column);
        std::iter::once(names.unwrap_or(0)).chain(columns).collect()
    }

    fn width(&self) -> usize {
        let widths = self.widths();
        widths.iter().sum::<usize>() + GAP.len() * widths.len().saturating_sub(1)
    }

    fn text(&self) -> String {
        let widths = self.widths();
        let mut text = String::new();
        let mut line = |name: &str, cells: &[&str]| {
            let texts = std::iter::once(&name).chain(cells).zip(&widths);
            let padded: Vec<String> = texts
                .map(|(text, &width)| format!("{text:<width$}"))
                .collect();
            text.push_str(padded.join(GAP).trim_end());
            text.push('\n');
        };
        let titles: Vec<&str> = self.columns.iter().map(String::as_str).collect();
        line("", &titles);
        for (name, cells) in &self.rows {
            let lines = cells.iter().map(Vec::len).max().unwrap_or(0).max(1);
            for at in 0..lines {
                let part = |cell: &'_ Cell| cell.get(at).cloned().unwrap_or_default();
                let parts: Vec<String> = cells.iter().map(part).collect();
                let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
                line(if at == 0 { name } else { "" }, &parts);
            }
        }
        text
    }
}

/// Handlers by event, from the detail of a state: `EVENT: handler, ...`, after its
/// sub-behaviour.
fn handlers(node: &GraphNode) -> Vec<(String, String)> {
    let pair = |part: &str| {
        let (event, handler) = match part.strip_prefix(RUNS) {
            Some(behaviour) => (RUNS.trim(), behaviour),
            None => part.split_once(": ")?,
        };
        Some((event.to_owned(), handler.to_owned()))
    };
    node.detail.split(", ").filter_map(pair).collect()
}

/// All events, in an order that agrees with that of each state: the precedence.
fn order(known: &[Vec<(String, String)>]) -> Vec<String> {
    let events = |one: &Vec<(String, String)>| one.iter().map(|(event, _)| event.clone()).collect();
    let mut left: Vec<Vec<String>> = known.iter().map(events).collect();
    let mut all = Vec::new();
    loop {
        let heads: Vec<&String> = left.iter().filter_map(|list| list.first()).collect();
        // The next event is one before which no state has another. If the lists contradict each
        // other, the first head is used, so that the loop ends.
        let is_first = |event: &&&String| {
            let place = |list: &Vec<String>| list.iter().position(|one| one == **event);
            left.iter().all(|list| place(list).unwrap_or(0) == 0)
        };
        let next = heads.iter().find(is_first).or(heads.first());
        let Some(next) = next.map(|event| (*event).clone()) else {
            return all;
        };
        for list in &mut left {
            list.retain(|event| *event != next);
        }
        all.push(next);
    }
}
