//! Changes of the statuses of nodes, and the transitions that follow from them.

use super::TraceModel;

/// Until its states are told again, a task that was reset has taken no transition (simulated s).
// All statuses are sent ten times a second.
const RESET_S: f64 = 0.12;

impl TraceModel {
    /// Whether with `letter` a node is left.
    pub(super) fn is_left(&self, graph: usize, node: usize, letter: u8) -> bool {
        let picture = self.pictures.get(graph);
        let known = picture.and_then(|picture| picture.letters.get(node));
        known.is_some_and(|known| leaves(*known, letter))
    }

    pub(super) fn letter(&mut self, graph: usize, node: usize, letter: u8, reason: &str) {
        let is_reset = self.is_reset();
        let Some(picture) = self.pictures.get_mut(graph) else {
            return;
        };
        let Some(known) = picture
            .letters
            .get_mut(node)
            .filter(|known| **known != letter)
        else {
            return;
        };
        let before = std::mem::replace(known, letter);
        self.changes.letters.insert(graph);
        if letter == b'R' {
            self.changes.started.insert((graph, node));
        }
        // A tree has no edges, so no transition is searched for.
        if picture.edges.is_empty() {
            return;
        }
        // A transition is two lines: one state is left, another is entered.
        if leaves(before, letter) {
            picture.left = Some(node);
        // The last state of a job has succeeded, or failed, as soon as it is entered.
        } else if letter != b'I'
            && let Some(from) = picture.left.take()
            && !is_reset
        {
            picture.taken = Some(picture.edge_taken(from, node, reason));
            self.changes.taken.insert(graph);
        }
    }

    /// Forgets the last transitions when the task was reset: a reset sets the state without one.
    pub(super) fn see_reset(&mut self, text: &str) {
        if text != "[task] reset" {
            return;
        }
        self.reset_s = Some(self.time_s);
        for (graph, picture) in self.pictures.iter_mut().enumerate() {
            picture.left = None;
            if picture.taken.take().is_some() {
                self.changes.taken.insert(graph);
            }
        }
    }

    /// Whether the task was reset just now, so that its states change without a transition.
    fn is_reset(&self) -> bool {
        let since_s = self.reset_s.map(|reset_s| self.time_s - reset_s);
        since_s.is_some_and(|since_s| (0.0..RESET_S).contains(&since_s))
    }
}

/// Whether the status of a state from `before` to `letter` says that the state is left. The last
/// state of a job succeeds or fails while it is active; it is left when it becomes idle.
fn leaves(before: u8, letter: u8) -> bool {
    (before == b'R' && letter != b'R') || (before != b'I' && letter == b'I')
}
