//! How often an arm touched obstacles, and itself, as a snapshot has it.

use serde::{Deserialize, Serialize};

/// Counts of one arm: part of every snapshot.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct TouchCount {
    /// Times an obstacle began to be touched.
    pub(crate) obstacles: u64,
    /// Times two parts of the arm began to overlap.
    pub(crate) own_parts: u64,
    touches_obstacle: bool,
    touches_itself: bool,
}

impl TouchCount {
    /// Counts continue over a reset of the scene.
    pub(crate) fn carry_over(&mut self, before: &Self) {
        (self.obstacles, self.own_parts) = (before.obstacles, before.own_parts);
    }

    pub(super) fn see_obstacle(&mut self, touches: bool) {
        self.obstacles += u64::from(touches && !self.touches_obstacle);
        self.touches_obstacle = touches;
    }

    pub(super) fn see_itself(&mut self, touches: bool) {
        self.own_parts += u64::from(touches && !self.touches_itself);
        self.touches_itself = touches;
    }
}
