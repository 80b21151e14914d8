//! Faulty arms, and their reasons.

use crate::arm::arms::Arms;
use crate::arm::measured::Measured;
use crate::arm::multibody::Arm;
use crate::arm::violations;

impl Arms {
    /// Number of faulty arms.
    pub(crate) fn faults(&self) -> usize {
        let drives = self.drives.iter();
        drives.filter(|drive| drive.watchdog().fault).count()
    }

    /// The reason of each faulty arm, one line each; empty if no arm is faulty.
    pub(crate) fn fault_words(&self) -> String {
        let arms = self.bodies.iter().zip(&self.measured).zip(&self.drives);
        let at_fault = arms.enumerate().filter(|(_, (_, d))| d.watchdog().fault);
        let words = at_fault.map(|(index, ((arm, measured), _))| {
            let why = reason(arm, measured);
            format!("arm {index} is at fault until the scene is reset: {why}")
        });
        words.collect::<Vec<_>>().join("\n")
    }
}

fn reason(arm: &Arm, measured: &Measured) -> String {
    let mut joints = arm.robot.arm_joints.iter();
    let outside = joints
        .find(|&&joint| violations::outside(measured.positions[joint], &arm.robot.joints[joint]));
    // The joint with its limits is the more useful reason; without one the engine acted.
    let Some(&joint) = outside else {
        return "the engine disabled a body of it".to_owned();
    };
    let spec = &arm.robot.joints[joint];
    let name = arm.robot.chain.joints().get(joint);
    format!(
        "joint '{}' stays at {:.3}, outside of its limits {:.3} to {:.3}: \
         something pushes it, or a collision shape of the robot is wrong",
        name.map_or("?", |joint| joint.name.as_str()),
        measured.positions[joint],
        spec.lower,
        spec.upper
    )
}
