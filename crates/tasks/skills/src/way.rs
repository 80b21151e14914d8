//! The path of a motion to its target: posture, corridor, obstacles.

use ipc_types::MAX_JOINTS;

use crate::setup::Setup;

/// The default leaves the path to the controller, clear of all solid obstacles.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Way {
    /// Joint positions to lean to (rad or m).
    pub posture: Option<[f64; MAX_JOINTS]>,
    /// Direction of the approach corridor times its length, world frame (m).
    pub approach_m: [f64; 3],
    /// Width of the approach corridor (standard deviation, m); 0 for none.
    pub std_dev_m: f64,
    /// Obstacles that do not count, a bit for each.
    pub ignored: u64,
    /// Guides (obstacles that are not solid) that count, a bit for each.
    pub guides: u64,
}

impl Way {
    /// See [`ipc_types::ArmGoal::obstacle_mask`].
    pub fn obstacle_mask(&self, setup: &Setup) -> u64 {
        (setup.solid_obstacles | self.guides) & !self.ignored
    }
}
