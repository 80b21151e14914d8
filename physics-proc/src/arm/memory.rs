//! State of an arm outside of the engine: part of every snapshot.

use cell_model::{ArmSpec, ParallelGripper};
use serde::{Deserialize, Serialize};

use crate::arm::brake::Brakes;
use crate::arm::delay::Delayed;
use crate::arm::touch_memory::TouchCount;
use crate::arm::watchdog::Watchdog;
use crate::gripper::parallel::GripperDrive;
use crate::gripper::suction::Suction;

/// The part of one arm.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ArmMemory {
    pub(crate) watchdog: Watchdog,
    pub(crate) brakes: Brakes,
    pub(crate) delayed: Delayed,
    pub(crate) gripper: GripperDrive,
    pub(crate) suction: Suction,
    pub(crate) touches: TouchCount,
    /// [`ipc_types::arm::StopAction`] of the last tick.
    pub(crate) stop_action: u32,
}

impl ArmMemory {
    /// At the start of a run.
    pub(crate) fn new(arm: &ArmSpec) -> Self {
        let fingers = arm.robot.gripper.as_ref();
        let open = |gripper: &ParallelGripper| {
            let home = gripper
                .finger_joints
                .iter()
                .filter_map(|&joint| arm.robot.joints.get(joint))
                .map(|spec| spec.home);
            GripperDrive::new(gripper, home.fold(0.0, f64::max))
        };
        Self {
            watchdog: Watchdog::new(&arm.home),
            brakes: Brakes::default(),
            delayed: Delayed::default(),
            gripper: fingers.map_or(GripperDrive::NONE, open),
            suction: Suction::default(),
            touches: TouchCount::default(),
            stop_action: 0,
        }
    }

    /// Counts by which a run is judged continue over a reset of the scene.
    pub(crate) fn carry_over(&mut self, before: &Self, tick: u64) {
        self.watchdog.carry_over(&before.watchdog, tick);
        self.touches.carry_over(&before.touches);
    }
}

/// Whether a cup of one of these arms holds `object`.
pub(crate) fn is_attached(arms: &[ArmMemory], object: usize) -> bool {
    let mut arms = arms.iter();
    arms.any(|arm| arm.suction.attached() == Some(object))
}
