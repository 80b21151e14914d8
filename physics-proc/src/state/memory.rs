//! State of the world outside of the engine: part of every snapshot.

use cell_model::Cell;
use serde::{Deserialize, Serialize};

use crate::arm::memory::ArmMemory;
use crate::equipment::devices::EquipmentMemory;
use crate::operator::drag::Drag;
use crate::operator::panel::Panel;

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
    /// The engine panicked and is not stepped any more.
    pub(crate) broken: bool,
}

impl Memory {
    /// At the start of a run.
    pub(crate) fn new(cell: &Cell) -> Self {
        Self {
            tick: 0,
            arms: cell.arms.iter().map(ArmMemory::new).collect(),
            drags: Vec::new(),
            equipment: EquipmentMemory::new(),
            panel: Panel::NEW,
            quarantined: 0,
            broken: false,
        }
    }

    /// Back to `initial` after a reset of the scene. Time, requests and the counts by which a
    /// run is judged (violations, contacts, refused commands) continue. Counts of events of a
    /// scene (bins, parts, grips) start from 0.
    pub(crate) fn reset_to(&mut self, initial: Self) {
        // A field that is not copied back below starts again with the scene.
        let before = std::mem::replace(self, initial);
        self.tick = before.tick;
        self.panel = before.panel;
        self.panel.scene_reset = self.panel.scene_reset.wrapping_add(1);
        self.quarantined = before.quarantined;
        self.equipment.carry_over(&before.equipment);
        for (arm, before) in self.arms.iter_mut().zip(&before.arms) {
            arm.carry_over(before, self.tick);
        }
    }
}
