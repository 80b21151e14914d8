//! The trace as messages to a page: all of it, or the changes since the last ones.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::picture::Picture;
use super::{Changes, TraceModel};

impl TraceModel {
    /// Messages about all changes since the last call.
    pub fn take_changes(&mut self) -> Vec<Value> {
        let changes = std::mem::take(&mut self.changes);
        let mut out = Vec::new();
        // Half a picture is not sent: its nodes arrive one per line.
        if changes.graphs && self.pictures.iter().all(Picture::is_whole) {
            out.push(self.graphs_message());
        } else {
            // The rest of the picture will follow.
            self.changes.graphs = changes.graphs;
        }
        for graph in &changes.letters {
            let mut message = self.statuses_message(*graph);
            if let Some(message) = &mut message {
                let started = changes.started.range((*graph, 0)..(graph + 1, 0));
                message["started"] = started.map(|(_, node)| *node).collect();
            }
            out.extend(message);
        }
        out.extend(changes.taken.iter().filter_map(|g| self.edge_message(*g)));
        for graph in 0..self.pictures.len() {
            out.extend(self.values_message(graph, Some(&changes)));
        }
        // The time of what changed; a late joiner is told no time, since it is not known.
        for message in &mut out {
            message["time_s"] = json!(self.time_s);
        }
        if !changes.lines.is_empty() {
            out.push(json!({ "t": "log", "lines": changes.lines }));
        }
        out
    }

    /// Messages that give a new page everything.
    pub fn full_state(&self) -> Vec<Value> {
        let mut out = vec![self.graphs_message()];
        for graph in 0..self.pictures.len() {
            out.extend(self.statuses_message(graph));
            out.extend(self.edge_message(graph));
            out.extend(self.values_message(graph, None));
        }
        out.push(json!({ "t": "log", "lines": self.log, "all": true }));
        out
    }

    /// As [`Self::full_state`], without the log.
    pub fn pictures_state(&self) -> Vec<Value> {
        let mut all = self.full_state();
        all.retain(|message| message["t"] != "log");
        all
    }

    fn graphs_message(&self) -> Value {
        let graphs: Vec<Value> = self.pictures.iter().map(Picture::to_json).collect();
        json!({ "t": "graphs", "graphs": graphs })
    }

    fn statuses_message(&self, graph: usize) -> Option<Value> {
        let letters = String::from_utf8(self.pictures.get(graph)?.letters.clone()).ok()?;
        Some(json!({ "t": "statuses", "graph": graph, "letters": letters }))
    }

    /// The transition taken last; null ends after a reset of the task.
    fn edge_message(&self, graph: usize) -> Option<Value> {
        let Some(edge) = &self.pictures.get(graph)?.taken else {
            let none =
                json!({ "t": "edge", "graph": graph, "from": null, "to": null, "label": "" });
            return self.reset_s.is_some().then_some(none);
        };
        let (from, to, label) = (edge.from, edge.to, &edge.label);
        Some(json!({ "t": "edge", "graph": graph, "from": from, "to": to, "label": label }))
    }

    /// Keys and guards: all, or the changed ones.
    fn values_message(&self, graph: usize, only: Option<&Changes>) -> Vec<Value> {
        let Some(picture) = self.pictures.get(graph) else {
            return Vec::new();
        };
        let mut out = Vec::new();
        let wanted = |set: Option<&BTreeSet<(usize, String)>>, name: &str| {
            set.is_none_or(|set| !set.is_empty() && set.contains(&(graph, name.to_owned())))
        };
        let keys = picture.keys.iter();
        let keys = keys.filter(|(name, _)| wanted(only.map(|n| &n.keys), name));
        let keys: BTreeMap<_, _> = keys.collect();
        if !keys.is_empty() {
            out.push(json!({ "t": "keys", "graph": graph, "values": keys }));
        }
        let guards = picture.guards.iter();
        let guards = guards.filter(|(name, _)| wanted(only.map(|n| &n.guards), name));
        let guards: BTreeMap<_, _> = guards.collect();
        if !guards.is_empty() {
            out.push(json!({ "t": "guards", "graph": graph, "values": guards }));
        }
        out
    }
}
