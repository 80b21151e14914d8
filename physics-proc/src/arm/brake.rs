//! The brakes of an arm whose drives have no power.

use cell_model::Robot;
use serde::{Deserialize, Serialize};

use crate::arm::multibody::DriveTarget;

/// Friction at every controlled joint, up to the joint's effort limit: a brake is built
/// to hold what its drive can move. It gives way like a spring of the drive's stiffness
/// until it slips, and stays where it slipped to.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Brakes {
    /// Held position of each joint (rad or m); empty while the brakes are released.
    held_at: Vec<f64>,
}

impl Brakes {
    pub(crate) fn release(&mut self) {
        self.held_at.clear();
    }

    /// The drive that is as strong as the brakes, by controlled joint. `positions` are
    /// measured, by joint of the chain.
    pub(crate) fn hold(&mut self, robot: &Robot, positions: &[f64]) -> Vec<DriveTarget> {
        let measured = || robot.arm_joints.iter().map(|joint| positions[*joint]);
        // Held where the arm is when the power ends, not at the setpoint: a brake does not
        // move a joint.
        if self.held_at.is_empty() {
            self.held_at = measured().collect();
        }
        let joints = self.held_at.iter_mut().zip(measured());
        let held = |((held_at, measured), spec): ((&mut f64, f64), &cell_model::JointSpec)| {
            // A push beyond the effort limit moves the held position along with the joint; it
            // stays there.
            let slips_at = spec.effort / spec.stiffness;
            *held_at = held_at.clamp(measured - slips_at, measured + slips_at);
            DriveTarget {
                position: *held_at,
                max_effort: spec.effort,
                ..DriveTarget::default()
            }
        };
        joints.zip(robot.arm_specs()).map(held).collect()
    }
}
