//! A tree of configurations that grows from one end of a path.

use crate::check::distance;

/// Configurations, each with the one that it was reached from.
#[derive(Debug)]
pub(crate) struct Tree {
    joints: usize,
    positions: Vec<f64>,
    parents: Vec<usize>,
}

impl Tree {
    pub(crate) fn new(root: &[f64]) -> Self {
        Self {
            joints: root.len(),
            positions: root.to_vec(),
            parents: vec![0],
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.parents.len()
    }

    pub(crate) fn at(&self, node: usize) -> &[f64] {
        &self.positions[node * self.joints..(node + 1) * self.joints]
    }

    pub(crate) fn add(&mut self, at: &[f64], parent: usize) -> usize {
        self.positions.extend_from_slice(at);
        self.parents.push(parent);
        self.parents.len() - 1
    }

    /// The nearest configuration, and its distance.
    pub(crate) fn nearest(&self, to: &[f64]) -> (usize, f64) {
        let mut best = (0, f64::INFINITY);
        for node in 0..self.len() {
            let off = distance(self.at(node), to);
            if off < best.1 {
                best = (node, off);
            }
        }
        best
    }

    /// The configurations from `node` to the root.
    pub(crate) fn way(&self, mut node: usize) -> Vec<Vec<f64>> {
        let mut way = vec![self.at(node).to_vec()];
        while node != 0 {
            node = self.parents[node];
            way.push(self.at(node).to_vec());
        }
        way
    }
}
