//! Faults of the arms: bodies that the engine disabled, and joints outside their limits.

use super::World;
use crate::arm::measured::Measured;
use crate::arm::multibody::Arm;
use crate::arm::violations;

impl World {
    /// Bodies the engine had to disable: an arm with such a link is at fault.
    pub(super) fn read_quarantine(&mut self) {
        if self.memory.broken {
            return;
        }
        for body in self.engine.quarantine().bodies() {
            self.memory.quarantined += 1;
            let at_fault = self.arms.iter().position(|arm| arm.bodies.contains(body));
            if let Some(arm) = at_fault {
                self.memory.arms[arm].watchdog.fault = true;
            }
        }
    }

    /// Counts the joints of each arm that are outside their limits in this tick.
    pub(super) fn count_outside(&mut self) {
        let arms = self.arms.iter().zip(&self.measured);
        for ((arm, measured), memory) in arms.zip(&mut self.memory.arms) {
            let joints = arm.robot.arm_joints.iter().filter(|&&joint| {
                violations::outside(measured.positions[joint], &arm.robot.joints[joint])
            });
            let outside = joints.count() as u64;
            memory.watchdog.count_outside(outside);
        }
    }

    /// Number of faulty arms.
    pub fn faults(&self) -> usize {
        let arms = self.memory.arms.iter();
        arms.filter(|arm| arm.watchdog.fault).count()
    }

    /// The reason of each faulty arm, one line each; empty if no arm is faulty.
    pub fn fault_words(&self) -> String {
        let arms = self.arms.iter().zip(&self.measured).zip(&self.memory.arms);
        let at_fault = arms.enumerate().filter(|(_, (_, m))| m.watchdog.fault);
        let words = |(index, ((arm, measured), _)): (usize, ((&Arm, &Measured), _))| {
            // The joint with its limits is the more useful reason; without one the engine
            // acted.
            let outside = arm.robot.arm_joints.iter().find(|&&joint| {
                violations::outside(measured.positions[joint], &arm.robot.joints[joint])
            });
            let why = match outside {
                None => "the engine disabled a body of it".to_owned(),
                Some(&joint) => {
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
            };
            format!("arm {index} is at fault until the scene is reset: {why}")
        };
        at_fault.map(words).collect::<Vec<_>>().join("\n")
    }
}
