//! The events of a tree in one tick, as trace lines.

use behavior::board::{Board, Fault};
use behavior::tree::{EventKind, Host, Tree};
use behavior::{Graph, Value};
use ipc_types::trace::TraceEvent;

use crate::output::Output;

/// Reports the events of a tree, tick by tick.
#[derive(Clone, Debug, Default)]
pub struct TreeTrace {
    ids: Vec<String>,
    /// The fault of the tick before: a lasting fault is reported once.
    fault: Option<(usize, Fault)>,
    keys: KeyWatch,
}

impl TreeTrace {
    /// For a tree with that picture.
    pub fn new(graph: &Graph) -> Self {
        Self {
            ids: graph.nodes.iter().map(|n| n.id.clone()).collect(),
            ..Self::default()
        }
    }

    /// Adds what happened in the last tick of `tree`, which is picture `graph`
    /// of the policy, and the changed values of its local keys.
    pub fn tick<H: Host>(&mut self, tree: &Tree<H>, graph: usize, out: &mut Output) {
        let mut now = None;
        for event in tree.events() {
            let place = (graph, event.node);
            match event.kind {
                EventKind::Status { from, to, reason } => {
                    let reason = reason.map_or("", behavior::ResetReason::name);
                    out.status(place, from, to, reason);
                }
                EventKind::Guard { holds } => out.guard(place, "guard", holds),
                EventKind::Fault(fault) => {
                    // Compared with the tick before, not with the last fault: one that returns
                    // after a tick without it is reported again.
                    now = Some((event.node, fault));
                    if self.fault != now {
                        let id = self.ids.get(event.node).map_or("?", String::as_str);
                        out.event(
                            TraceEvent::Fault,
                            format_args!("[fault] node '{id}': {fault}"),
                        );
                    }
                }
                EventKind::Overflow => {
                    out.event(
                        TraceEvent::Fault,
                        format_args!("[fault] more happened in one tick than is kept"),
                    );
                }
            }
        }
        self.fault = now;
        self.keys.changes(tree.local(), "local", graph, out);
    }
}

/// Remembers the values of a board in order to report changes.
#[derive(Clone, Debug, Default)]
pub struct KeyWatch {
    known: Vec<Option<Value>>,
}

impl KeyWatch {
    /// Adds the keys of `board` whose value is new since the last call.
    /// Quantities (positions, leases) change with every observation and are omitted;
    /// positions are part of the goals (ADR 0009).
    pub fn changes(&mut self, board: &Board, scope: &str, graph: usize, out: &mut Output) {
        for (index, key) in board.keys().enumerate() {
            let value = board.value(index);
            if self.known.len() <= index {
                // A default is known from the file and is not a change.
                self.known.push(key.default);
            }
            let Some(known) = self.known.get_mut(index).filter(|known| **known != value) else {
                continue;
            };
            *known = value;
            match value {
                Some(Value::Number(_) | Value::Numbers(_)) => {}
                Some(value) => out.key(graph, scope, &key.name, &value),
                None => out.key(graph, scope, &key.name, &"unset"),
            }
        }
    }
}
