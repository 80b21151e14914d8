//! What the world remembers besides the engine: part of every snapshot.

use cell_model::Cell;
use serde::{Deserialize, Serialize};

use crate::drag::Drag;
use crate::equipment::EquipmentMemory;
use crate::gripper::GripperDrive;
use crate::panel::Panel;
use crate::suction::Suction;
use crate::watchdog::Watchdog;

/// Everything outside the engine that decides the next tick.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Memory {
    pub(crate) tick: u64,
    pub(crate) arms: Vec<ArmMemory>,
    pub(crate) drags: Vec<Drag>,
    pub(crate) equipment: EquipmentMemory,
    pub(crate) panel: Panel,
    /// Bodies the engine disabled since the start.
    pub(crate) quarantined: u32,
    /// The engine cannot go on.
    pub(crate) broken: bool,
}

/// The part of one arm.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct ArmMemory {
    pub(crate) watchdog: Watchdog,
    pub(crate) gripper: GripperDrive,
    pub(crate) suction: Suction,
    /// [`ipc_types::arm::StopAction`] of the last tick.
    pub(crate) stop_action: u32,
}

impl Memory {
    /// At the start of a run.
    pub(crate) fn new(cell: &Cell) -> Self {
        let arms = cell.arms.iter().map(|arm| {
            let fingers = arm.robot.gripper.as_ref();
            let open = |gripper: &cell_model::ParallelGripper| {
                let home = gripper
                    .finger_joints
                    .iter()
                    .filter_map(|&joint| arm.robot.joints.get(joint))
                    .map(|spec| spec.home);
                GripperDrive::new(gripper, home.fold(0.0, f64::max))
            };
            ArmMemory {
                watchdog: Watchdog::new(&arm.home),
                gripper: fingers.map_or(GripperDrive::NONE, open),
                suction: Suction::default(),
                stop_action: 0,
            }
        });
        Self {
            tick: 0,
            arms: arms.collect(),
            drags: Vec::new(),
            equipment: EquipmentMemory::new(),
            panel: Panel::NEW,
            quarantined: 0,
            broken: false,
        }
    }

    /// Back to `initial` after a reset of the scene: time, requests and counts
    /// go on.
    pub(crate) fn reset_to(&mut self, initial: Self) {
        let before = std::mem::replace(self, initial);
        self.tick = before.tick;
        self.panel = before.panel;
        self.panel.scene_reset = before.panel.scene_reset.wrapping_add(1);
        self.quarantined = before.quarantined;
        self.equipment.carry_over(&before.equipment);
        for (arm, before) in self.arms.iter_mut().zip(before.arms) {
            arm.watchdog.carry_over(&before.watchdog, self.tick);
            arm.suction.carry_over(&before.suction);
        }
    }
}
