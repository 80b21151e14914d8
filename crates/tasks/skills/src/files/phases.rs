//! The phase that people and scripts see of a policy with several arms: the leaf that any arm
//! entered last, as `LEFT_LIFT`.

use behavior::Graph;
use behavior::graph::GraphNode;
use cell_model::runs::phase_name;
use ipc_types::Text;
use serde::{Deserialize, Serialize};

/// A phase's name.
pub(super) type Phase = Text<32>;

/// The leaf of each arm, and the arm that is shown. If several arms enter a leaf in the same
/// decision, the second is shown one decision later, so that a script sees every entry.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Shown {
    /// Node, by arm.
    at: Vec<Option<usize>>,
    /// Arms whose entry was not shown yet, oldest first.
    waiting: Vec<usize>,
    /// The arm that is shown.
    arm: Option<usize>,
}

impl Shown {
    pub(super) fn new(arms: usize) -> Self {
        Self {
            at: vec![None; arms],
            waiting: Vec::with_capacity(arms),
            arm: None,
        }
    }

    /// Records the leaf of `arm` after its tick.
    pub(super) fn note(&mut self, arm: usize, node: Option<usize>) {
        let Some(at) = self.at.get_mut(arm) else {
            return;
        };
        // Staying at a leaf does not count as an entry: a script counts entries.
        if *at == node {
            return;
        }
        *at = node;
        if node.is_some() && !self.waiting.contains(&arm) {
            self.waiting.push(arm);
        }
    }

    /// Shows the next entry; returns whether there was one.
    pub(super) fn advance(&mut self) -> bool {
        if self.waiting.is_empty() {
            return false;
        }
        self.arm = Some(self.waiting.remove(0));
        true
    }

    /// The arm and the node that are shown.
    pub(super) fn current(&self) -> Option<(usize, usize)> {
        let arm = self.arm?;
        Some((arm, (*self.at.get(arm)?)?))
    }

    /// Restores the state of a checkpoint. `at` are the present leaves of the arms: in an
    /// edited file they have other numbers, which does not count as an entry.
    pub(super) fn take(&mut self, other: Self, at: Vec<Option<usize>>) {
        let arms = at.len();
        let same = other.at == at && other.waiting.iter().all(|arm| *arm < arms);
        *self = Self {
            waiting: if same { other.waiting } else { Vec::new() },
            at,
            arm: other.arm,
        };
    }
}

/// Names of the phases of all nodes in a tree of `robot`.
pub(super) fn names(robot: &str, graph: &Graph) -> Vec<Phase> {
    let nodes = graph.nodes.iter();
    let name = |node: &GraphNode| Text::new(&phase_name::of_arm(robot, &node.name));
    nodes.map(name).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_entries() -> Shown {
        let mut shown = Shown::new(2);
        shown.note(0, Some(3));
        shown.note(1, Some(4));
        assert!(shown.advance());
        assert_eq!(shown.current(), Some((0, 3)));
        shown
    }

    #[test]
    fn two_entries_of_one_decision_are_shown_one_after_the_other() {
        let mut shown = two_entries();
        shown.note(0, Some(3));
        assert!(shown.advance());
        assert_eq!(shown.current(), Some((1, 4)));
        assert!(!shown.advance());
        assert_eq!(shown.current(), Some((1, 4)));
    }

    #[test]
    fn a_checkpoint_keeps_the_entry_that_waits_unless_the_nodes_are_others() {
        let mut same = Shown::new(2);
        same.take(two_entries(), vec![Some(3), Some(4)]);
        assert_eq!(same, two_entries());
        let mut edited = Shown::new(2);
        edited.take(two_entries(), vec![Some(5), Some(4)]);
        assert!(!edited.advance());
        assert_eq!(edited.current(), Some((0, 5)));
    }
}
