//! A pose of the TCP on a path, and the way in which it is approached.

use ipc_types::validate::MAX_JOINT_POSITION;
use ipc_types::{MAX_JOINTS, Pose};
use serde::{Deserialize, Serialize};

use crate::pose::{KeptPose, within};

/// Largest number of waypoints of a path: a path is part of the checkpoint.
pub const MAX_WAYPOINTS: usize = 16;
/// Largest length and width of a corridor (m), as in the check of the message.
pub const MAX_APPROACH_M: f64 = 2.0;

/// A goal of the TCP, and its approach. Plain data, for the checkpoint.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Waypoint {
    /// Position, world frame (m).
    pub position: [f64; 3],
    /// Orientation, world frame, w x y z.
    pub orientation_wxyz: [f64; 4],
    /// Joint configuration to lean to (rad).
    pub posture: Option<[f64; MAX_JOINTS]>,
    /// See [`robocell_task::output::ArmIntent::approach`].
    pub approach: [f64; 3],
    /// See [`robocell_task::output::ArmIntent::approach_std_dev`].
    pub approach_std_dev: f64,
    /// Fixtures that are obstacles on the way to it, a bit for each.
    pub obstacle_mask: u64,
    /// Objects that are obstacles, a bit for each.
    pub object_mask: u64,
    /// Time in which the target moves here from the waypoint before, at a constant pace
    /// (ticks); 0: it jumps.
    pub glide_ticks: u64,
    /// Moves the joints to the posture, whose TCP pose this is, instead of the TCP to the pose;
    /// the path of the TCP follows from that.
    pub by_joints: bool,
    /// Follows a planned path, around obstacles.
    pub planned: bool,
}

impl Waypoint {
    /// Straight to `pose`, with every obstacle in effect.
    pub const fn new(pose: Pose) -> Self {
        Self {
            position: pose.position,
            orientation_wxyz: pose.orientation_wxyz,
            posture: None,
            approach: [0.0; 3],
            approach_std_dev: 0.0,
            obstacle_mask: u64::MAX,
            object_mask: u64::MAX,
            glide_ticks: 0,
            by_joints: false,
            planned: false,
        }
    }

    /// Leans to a joint configuration.
    #[must_use]
    pub const fn leaning(self, posture: [f64; MAX_JOINTS]) -> Self {
        Self {
            posture: Some(posture),
            ..self
        }
    }

    /// Moves the joints to that configuration, whose TCP pose this is.
    #[must_use]
    pub const fn by_joints(self, posture: [f64; MAX_JOINTS]) -> Self {
        Self {
            by_joints: true,
            ..self.leaning(posture)
        }
    }

    /// Follows a planned path, around obstacles.
    #[must_use]
    pub const fn planned(self) -> Self {
        Self {
            planned: true,
            ..self
        }
    }

    /// At a constant pace, in `ticks` (ms).
    #[must_use]
    pub const fn gliding(self, ticks: u64) -> Self {
        Self {
            glide_ticks: ticks,
            ..self
        }
    }

    /// Through a corridor along `approach` (m) of width `std_dev` (m).
    #[must_use]
    pub const fn through(self, approach: [f64; 3], std_dev: f64) -> Self {
        Self {
            approach,
            approach_std_dev: std_dev,
            ..self
        }
    }

    /// Only these fixtures and objects are obstacles.
    #[must_use]
    pub const fn avoiding(self, obstacle_mask: u64, object_mask: u64) -> Self {
        Self {
            obstacle_mask,
            object_mask,
            ..self
        }
    }

    /// Whether a restored waypoint is valid.
    pub(super) fn is_sound(&self) -> bool {
        KeptPose::from(self.pose()).is_sound()
            && within(self.posture.as_slice().as_flattened(), MAX_JOINT_POSITION)
            && within(&self.approach, MAX_APPROACH_M)
            && within(&[self.approach_std_dev], MAX_APPROACH_M)
    }

    /// Its pose.
    pub const fn pose(&self) -> Pose {
        Pose {
            position: self.position,
            orientation_wxyz: self.orientation_wxyz,
        }
    }
}
