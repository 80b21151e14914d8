//! The goal of the tool, as planning uses it.

use nalgebra::{Isometry3, Vector3};

use crate::checkpoint::{CheckpointError, Codec};
use crate::convert::angle;

/// A pose of the TCP in the arm's base frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlanGoal {
    /// The pose (m).
    pub pose: Isometry3<f64>,
    /// Direction and length of the last part of the motion (m); zero if it is free.
    pub approach: Vector3<f64>,
    /// The goal is the posture; `pose` is the pose of the tool there.
    pub by_joints: bool,
}

impl PlanGoal {
    /// Distance (m) and angle (rad) to another goal.
    pub(crate) fn off(&self, other: &Self) -> (f64, f64) {
        self.off_pose(&other.pose)
    }

    /// Distance (m) and angle (rad) to a pose.
    pub(crate) fn off_pose(&self, pose: &Isometry3<f64>) -> (f64, f64) {
        let way = self.pose.translation.vector - pose.translation.vector;
        (way.norm(), angle(&self.pose.rotation, &pose.rotation))
    }

    /// Whether motion policies make the last part of the motion alone.
    pub(crate) fn ends_alone(&self) -> bool {
        // With joints as the goal the posture itself attracts the arm; an approach is the
        // corridor's.
        self.by_joints || self.approach != Vector3::zeros()
    }

    pub(crate) fn checkpoint(&mut self, codec: &mut Codec<'_>) -> Result<(), CheckpointError> {
        codec.pose(&mut self.pose)?;
        codec.f64s(self.approach.iter_mut())?;
        codec.bool("goal by joints", &mut self.by_joints)
    }
}
