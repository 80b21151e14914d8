//! The task's trace, combined for the page: pictures, statuses of their nodes, the last edge
//! taken, values, the log.
//!
//! The trace is text from another process, possibly of a recording of another version: every
//! index is checked, every table has a limit, and a limit that is exceeded is reported once
//! instead of growing. A page that joins late gets the same messages as one that saw every
//! change.

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use behavior::graph::{GraphEdge, GraphNode};
use cell_run::incident::Head;
use ipc_types::TraceLine;
use ipc_types::trace::{FIELD_END, TraceEvent, TraceKind};
use serde_json::{Value, json};

pub mod history;
mod messages;
mod picture;
mod statuses;
pub mod text_log;

use picture::Picture;

/// Lines of the log sent to a late joiner.
// More than a person reads back; older ones are in the recording.
pub const KEPT_LINES: usize = 500;
/// Largest number of pictures, of nodes and edges of one, and of names of guards and keys: more
/// than any policy has, except for edges. A page would not draw more in time.
const MAX_GRAPHS: usize = 16;
const MAX_NODES: usize = 16_384;
const MAX_EDGES: usize = 4096;
const MAX_NAMES: usize = 512;
/// Interval at which an unchanged result is sent again, so that a page knows its age (simulated
/// s).
// Twice a second: a guard that is evaluated looks alive, and the messages stay few.
const RESEND_S: f64 = 0.5;

/// Changes since the last message.
#[derive(Clone, Debug, Default)]
struct Changes {
    graphs: bool,
    letters: BTreeSet<usize>,
    /// Nodes, with their picture, that began to run, also those that had run before.
    started: BTreeSet<(usize, usize)>,
    taken: BTreeSet<usize>,
    keys: BTreeSet<(usize, String)>,
    guards: BTreeSet<(usize, String)>,
    lines: Vec<Value>,
}

/// The trace of a task, as received so far.
#[derive(Clone, Debug, Default)]
pub struct TraceModel {
    pictures: Vec<Picture>,
    log: VecDeque<Value>,
    changes: Changes,
    /// Lines since the last call of `take_own_lines` that are not of the task's trace.
    own: Vec<Value>,
    /// Generation of physics of the lines; unknown in a recording.
    epoch: Option<u32>,
    /// Simulated time of the newest line (s).
    time_s: f64,
    /// Simulated time of the newest reset of the task (s).
    reset_s: Option<f64>,
    /// Limits that were exceeded, each reported once.
    exceeded: BTreeSet<&'static str>,
}

impl TraceModel {
    /// Sets the epoch, a generation of physics, of all lines from now on.
    pub fn set_epoch(&mut self, epoch: u32) {
        self.epoch = Some(epoch);
    }

    /// Takes one line; invalid ones are ignored.
    pub fn take(&mut self, line: &TraceLine) {
        let (graph, node) = (line.graph as usize, line.node as usize);
        let text = line.text.as_str();
        let time_s = seconds(line);
        self.time_s = time_s;
        match TraceKind::from_code(line.kind) {
            Some(kind) if kind.is_for_people() => {
                self.see_reset(text);
                self.keep(log_line(line));
            }
            Some(TraceKind::Node) => self.node(graph, node, line),
            Some(TraceKind::Edge) => self.edge(graph, line),
            Some(TraceKind::Status) => {
                let letters = b"IRSFR";
                // The letters of the statuses in the order of their
                // codes; unknown ones are idle.
                let letter = letters.get(line.to as usize).copied().unwrap_or(b'I');
                self.letter(graph, node, letter, text);
            }
            Some(TraceKind::Statuses) => {
                // A state that is left comes before the one that is entered, in any order of their numbers.
                for leaves in [true, false] {
                    for (offset, letter) in text.bytes().enumerate() {
                        let (node, letter) = (node.saturating_add(offset), page_letter(letter));
                        if self.is_left(graph, node, letter) == leaves {
                            self.letter(graph, node, letter, "");
                        }
                    }
                }
            }
            Some(TraceKind::Guard) => {
                self.guard((graph, node), text, line.to == 1, time_s);
            }
            Some(TraceKind::Key) => self.key(graph, text, time_s),
            Some(TraceKind::Log | TraceKind::Transition | TraceKind::Lifecycle) | None => {}
        }
    }

    /// As [`Self::take`], without lines of the log.
    pub fn take_picture(&mut self, line: &TraceLine) {
        if TraceKind::from_code(line.kind).is_some_and(TraceKind::is_for_people) {
            self.time_s = seconds(line);
            self.see_reset(line.text.as_str());
        } else {
            self.take(line);
        }
    }

    /// Adds a line to the log; an `event` is marked on the timeline.
    pub fn add_log_line(&mut self, time_s: f64, kind: &str, event: TraceEvent, text: &str) {
        self.keep_own(line_of(time_s, kind, event, text));
    }

    /// Adds an incident to the log, with the number by which the page opens it.
    pub fn add_incident(&mut self, head: &Head, what: &str) {
        let number = head.number;
        self.keep_own(json!({
            "time_s": head.sim_time_s, "kind": "lifecycle",
            "text": format!("incident {number}: {what}"),
            "mark": "incident", "incident": number,
        }));
    }

    /// Puts lines of an earlier start of the monitor at the start of the log.
    pub fn restore_log(&mut self, lines: Vec<Value>) {
        self.log.extend(lines);
    }

    /// Adds a line that a monitor added when this was recorded.
    pub fn add_recorded(&mut self, line: Value) {
        self.keep(line);
    }

    /// Lines since the last call that are not of the task's trace.
    pub fn take_own_lines(&mut self) -> Vec<Value> {
        std::mem::take(&mut self.own)
    }

    fn keep_own(&mut self, line: Value) {
        if self.own.len() < KEPT_LINES {
            self.own.push(line.clone());
        }
        self.keep(line);
    }

    fn keep(&mut self, mut line: Value) {
        line["epoch"] = json!(self.epoch);
        self.changes.lines.push(line.clone());
        // No page was connected for a while: only as many are sent as a late joiner would get.
        if self.changes.lines.len() > KEPT_LINES {
            self.changes.lines.remove(0);
        }
        self.log.push_back(line);
        if self.log.len() > KEPT_LINES {
            self.log.pop_front();
        }
    }

    /// The pictures without log and changes.
    pub fn without_log(&self) -> Self {
        Self {
            pictures: self.pictures.clone(),
            ..Self::default()
        }
    }

    fn guard(&mut self, (graph, node): (usize, usize), name: &str, holds: bool, time_s: f64) {
        let Some(picture) = self.pictures.get_mut(graph) else {
            return;
        };
        // A guard without its own name has that of its node.
        let of_node = picture.nodes.get(node).filter(|_| name == "guard");
        let name = of_node.map_or(name, |node| &node.name).to_owned();
        let room = picture.guards.len() < MAX_NAMES || picture.guards.contains_key(&name);
        if !room {
            return self.exceed(time_s, "guards", MAX_NAMES);
        }
        // Sent when it changes, and now and then when not:
        // guards are evaluated in every decision.
        let sent_s = picture.guards_sent_s.get(&name);
        let is_recent = sent_s.is_some_and(|sent_s| (0.0..RESEND_S).contains(&(time_s - sent_s)));
        if picture.guards.insert(name.clone(), holds) != Some(holds) || !is_recent {
            picture.guards_sent_s.insert(name.clone(), time_s);
            self.changes.guards.insert((graph, name));
        }
    }

    /// Reports once that some `what` beyond `limit` are not shown.
    fn exceed(&mut self, time_s: f64, what: &'static str, limit: usize) {
        if self.exceeded.insert(what) {
            let text = format!("[monitor] a picture of the task shows {limit} {what}, not all");
            self.keep(line_of(time_s, "lifecycle", TraceEvent::None, &text));
        }
    }

    fn key(&mut self, graph: usize, text: &str, time_s: f64) {
        let (Some(picture), Some((name, value))) =
            (self.pictures.get_mut(graph), text.split_once('='))
        else {
            return;
        };
        let room = picture.keys.len() < MAX_NAMES || picture.keys.contains_key(name);
        let known = picture.keys.get(name).is_some_and(|known| known == value);
        if !room {
            self.exceed(time_s, "keys", MAX_NAMES);
        } else if !known {
            picture.keys.insert(name.to_owned(), value.to_owned());
            self.changes.keys.insert((graph, name.to_owned()));
        }
    }

    fn node(&mut self, graph: usize, node: usize, line: &TraceLine) {
        let count = line.to as usize;
        let time_s = seconds(line);
        // Limits before memory: numbers of a damaged line must not reserve it.
        if graph >= MAX_GRAPHS {
            return self.exceed(time_s, "graphs", MAX_GRAPHS);
        }
        if count > MAX_NODES {
            return self.exceed(time_s, "nodes", MAX_NODES);
        }
        // Also keeps the parent, which is checked below, inside the picture.
        if node >= count {
            return;
        }
        if self.pictures.len() <= graph {
            self.pictures.resize_with(graph + 1, Picture::default);
        }
        let Some(picture) = self.pictures.get_mut(graph) else {
            return;
        };
        let mut fields = line.text.as_str().split(FIELD_END).map(str::to_owned);
        let mut field = || fields.next().unwrap_or_default();
        let name = field();
        let spec = GraphNode {
            id: field(),
            kind: field(),
            name: field(),
            parent: (line.from as usize).checked_sub(1).filter(|p| *p < node),
            detail: field(),
        };
        if picture.name != name || picture.nodes.len() != count {
            // Another policy: nothing of the former one stays.
            *picture = Picture {
                name,
                ..Picture::default()
            };
            picture.nodes = vec![unnamed_node(); count].into();
            picture.letters.resize(count, b'I');
            self.changes.graphs = true;
            self.changes.letters.insert(graph);
            // A new first picture means that all others are of the policy before.
            if graph == 0 {
                self.pictures.truncate(1);
            }
        }
        let Some(picture) = self.pictures.get_mut(graph) else {
            return;
        };
        if picture.nodes.get(node).is_some_and(|known| *known != spec) {
            if let Some(known) = Arc::make_mut(&mut picture.nodes).get_mut(node) {
                *known = spec;
            }
            self.changes.graphs = true;
        }
    }

    fn edge(&mut self, graph: usize, line: &TraceLine) {
        let Some(picture) = self.pictures.get_mut(graph) else {
            return;
        };
        let edge = GraphEdge {
            from: line.from as usize,
            to: line.to as usize,
            label: line.text.as_str().to_owned(),
        };
        let nodes = picture.nodes.len();
        let fits = edge.from < nodes && edge.to < nodes;
        // Edges are sent every second; known ones are no change.
        if !fits || picture.edges.contains(&edge) {
            return;
        }
        if picture.edges.len() == MAX_EDGES {
            return self.exceed(seconds(line), "edges", MAX_EDGES);
        }
        picture.edges.push(edge);
        self.changes.graphs = true;
    }
}

/// A line of the task's trace that is for people, as one of the log.
pub fn log_line(line: &TraceLine) -> Value {
    let kind = match TraceKind::from_code(line.kind) {
        Some(TraceKind::Transition) => "transition",
        Some(TraceKind::Lifecycle) => "lifecycle",
        _ => "log",
    };
    let event = TraceEvent::from_code(line.event).unwrap_or_default();
    line_of(seconds(line), kind, event, line.text.as_str())
}

/// A line of the log; an `event` is marked on the timeline.
fn line_of(time_s: f64, kind: &str, event: TraceEvent, text: &str) -> Value {
    json!({ "time_s": time_s, "kind": kind, "text": text, "mark": event.name() })
}

/// Simulated time of a line (s).
fn seconds(line: &TraceLine) -> f64 {
    line.header.sim_time_ns as f64 * 1.0e-9
}

/// The page has four letters: a node that is halting still runs.
fn page_letter(letter: u8) -> u8 {
    match letter {
        b'S' | b'F' => letter,
        b'R' | b'H' => b'R',
        _ => b'I',
    }
}

fn unnamed_node() -> GraphNode {
    GraphNode {
        id: String::new(),
        kind: String::new(),
        name: String::new(),
        parent: None,
        detail: String::new(),
    }
}

#[cfg(test)]
mod tests;
