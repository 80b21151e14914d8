//! The robot behind the interface.

use cell_worker::Start;
use fci::{Arm, Gripper};
use nalgebra::Vector3;

use crate::error::ProcessError;

/// Gravity in the world frame (m/s²).
const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// The robot behind the interface.
pub(crate) struct Robot {
    pub(crate) arm: Arm,
    pub(crate) gripper: Option<Gripper>,
    pub(crate) urdf: String,
}

impl Robot {
    pub(crate) fn new(start: &Start) -> Result<Self, ProcessError> {
        let spec = start.cell.arms.get(usize::from(start.arm));
        let wrong = |arm: &str, reason| ProcessError::Robot {
            arm: arm.to_owned(),
            reason,
        };
        let Some(spec) = spec else {
            return Err(wrong("without a place in the cell", fci::NotSevenJoints));
        };
        let gravity = spec.base.rotation.inverse() * GRAVITY;
        let arm = Arm::new(&spec.robot, &spec.home, gravity);
        Ok(Self {
            arm: arm.map_err(|reason| wrong(&spec.name, reason))?,
            gripper: spec.robot.gripper.as_ref().map(Gripper::new),
            urdf: fci::urdf(&spec.robot),
        })
    }
}
