//! The cell's equipment: what there is of it, and the task's word to it.

use cell_model::random::Random;
use cell_model::stop::DECISION_AGE_FIFO_TICKS;
use cell_model::{Cell, ObjectSpec};
use ipc_types::{Decision, EquipmentState};
use serde::{Deserialize, Serialize};

use crate::conveyor::Belt;
use crate::dispenser::{Dispenser, DispenserMemory};
use crate::objects::Fixtures;
use crate::parking::ParkingMemory;
use crate::sensors::Sensor;
use crate::supply::{Supply, SupplyMemory};
use crate::world::World;

/// A counter that went up by more than this was set, not counted.
const MOST_REQUESTS: u32 = 16;

/// What a cell has, and what its objects are.
pub(crate) struct Equipment {
    /// By object of the cell.
    pub(crate) specs: Vec<ObjectSpec>,
    pub(crate) belt: Option<Belt>,
    pub(crate) supply: Option<Supply>,
    pub(crate) dispenser: Option<Dispenser>,
    pub(crate) sensors: Vec<Sensor>,
    /// An object below this height is put away (m).
    pub(crate) clear_below: Option<f64>,
    pub(crate) seed: u64,
}

/// What it remembers: part of every snapshot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct EquipmentMemory {
    io: Io,
    /// The belt runs in this tick.
    pub(crate) running: bool,
    /// Decisions older than this stop the belt (ticks).
    pub(crate) decision_limit_ticks: u64,
    pub(crate) supply: SupplyMemory,
    pub(crate) dispenser: DispenserMemory,
    pub(crate) parking: ParkingMemory,
}

/// The counters of [`ipc_types::decision::CellIo`] as they were last seen.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Io {
    heard: bool,
    add_bin: u32,
    drop_parts: u32,
}

impl Io {
    /// New requests for bins and for drops. What is heard first is adopted: the
    /// task may have counted before this physics was. So is a counter that went
    /// down or far: a task that lost its record. One that goes on from its record
    /// asks as if it had never died.
    fn take(&mut self, decision: &Decision) -> (u32, u32) {
        let known = std::mem::replace(&mut self.heard, true);
        let more = |last: &mut u32, now: u32| {
            let more = now.wrapping_sub(*last);
            *last = now;
            if known && more <= MOST_REQUESTS {
                more
            } else {
                0
            }
        };
        (
            more(&mut self.add_bin, decision.io.add_bin),
            more(&mut self.drop_parts, decision.io.drop_parts),
        )
    }
}

impl Equipment {
    /// Of a cell whose fixtures are in the engine.
    pub(crate) fn new(cell: &Cell, fixtures: &Fixtures) -> Self {
        let supply = cell.conveyor.as_ref().and_then(|c| c.supply.as_ref());
        Self {
            specs: cell.objects.clone(),
            belt: cell
                .conveyor
                .as_ref()
                .and_then(|table| Belt::new(table, cell, fixtures)),
            supply: supply.map(|table| Supply::new(table, cell)),
            dispenser: cell
                .dispenser
                .as_ref()
                .map(|table| Dispenser::new(table, cell)),
            sensors: cell.sensors.iter().map(Sensor::new).collect(),
            clear_below: cell.clear_below_m,
            seed: cell.seed,
        }
    }

    fn listens(&self) -> bool {
        self.belt.is_some() || self.dispenser.is_some()
    }

    /// A generator for the `index`th thing of a device, so that what comes out
    /// depends on nothing but the seed and that number.
    pub(crate) fn random(&self, device: u64, index: u64) -> Random {
        let mut devices = Random::new(self.seed.wrapping_add(device << 32));
        Random::new(devices.bits().wrapping_add(index))
    }
}

impl EquipmentMemory {
    /// At the start of a run.
    pub(crate) fn new() -> Self {
        Self {
            io: Io::default(),
            running: false,
            decision_limit_ticks: DECISION_AGE_FIFO_TICKS,
            supply: SupplyMemory::default(),
            dispenser: DispenserMemory::default(),
            parking: ParkingMemory::default(),
        }
    }

    /// Counts go on over a reset of the scene; requests not yet met are gone.
    pub(crate) fn carry_over(&mut self, before: &Self) {
        self.io = before.io;
        self.decision_limit_ticks = before.decision_limit_ticks;
        self.supply.carry_over(&before.supply);
        self.dispenser.carry_over(&before.dispenser);
        self.parking.carry_over(&before.parking);
    }
}

impl World {
    /// Decisions older than this stop the belt, as they stop the arms (ticks).
    pub fn set_decision_limit(&mut self, ticks: u64) {
        self.memory.equipment.decision_limit_ticks = ticks;
    }

    /// What the equipment does before a step.
    pub(crate) fn run_equipment(&mut self, decision: Option<&Decision>) {
        if self.memory.broken {
            return;
        }
        self.clear_fallen();
        self.hear(decision);
        self.wake_belt();
        self.supply_bins();
        self.drop_parts();
    }

    fn hear(&mut self, decision: Option<&Decision>) {
        self.memory.equipment.running = false;
        let Some(decision) = decision.filter(|_| self.equipment.listens()) else {
            return;
        };
        let (bins, drops) = self.memory.equipment.io.take(decision);
        self.ask_for_bins(bins);
        self.ask_for_drops(drops);
        let age = self.memory.tick.saturating_sub(decision.header.tick);
        if age <= self.memory.equipment.decision_limit_ticks {
            self.memory.equipment.running = decision.io.conveyor_running == 1;
            self.inputs.push(ipc_types::Input {
                topic: ipc_types::topic::TopicId::Decision.code(),
                generation: decision.header.generation,
                seq: decision.header.seq,
                age_ticks: age,
            });
        }
    }

    /// What the equipment reports.
    pub(crate) fn equipment_state(&self) -> EquipmentState {
        let memory = &self.memory.equipment;
        let belt = self.equipment.belt.as_ref().filter(|_| memory.running);
        EquipmentState {
            conveyor_speed: belt.map_or(0.0, |belt| belt.speed),
            bins_supplied: memory.supply.supplied,
            supply_refusals: memory.supply.refusals,
            supply_refusal: memory.supply.refusal,
            parts_dropped: memory.dispenser.dropped,
            parts_waiting: memory.dispenser.waiting,
            cleared: memory.parking.cleared,
            sensors: self.sensors(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ipc_types::Wire;

    fn decision(add_bin: u32, drop_parts: u32) -> Decision {
        let mut decision = Decision::zeroed();
        (decision.io.add_bin, decision.io.drop_parts) = (add_bin, drop_parts);
        decision
    }

    #[test]
    fn only_counting_up_asks_for_something() {
        let mut io = Io::default();
        let mut take = |add_bin, drop_parts| io.take(&decision(add_bin, drop_parts));
        assert_eq!(take(5, 7), (0, 0), "heard first");
        assert_eq!(take(5, 7), (0, 0), "said again");
        assert_eq!(take(6, 9), (1, 2));
        assert_eq!(take(0, 9), (0, 0), "a task without its record");
        assert_eq!(take(16, 9), (16, 0));
        assert_eq!(take(33, 9), (0, 0), "set forward");
    }
}
