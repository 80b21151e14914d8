//! The equipment of the cell: its devices, and the requests of the task to them.

use cell_model::stop::DECISION_AGE_FIFO_TICKS;
use cell_model::{Cell, Shape};
use ipc_types::{Decision, EquipmentState, Input};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::PhysicsWorld;
use serde::{Deserialize, Serialize};

use crate::engine::objects::{Fixtures, Objects};
use crate::engine::{convert, shapes};
use crate::equipment::conveyor::{Belt, Hooks};
use crate::equipment::dispenser::{Dispenser, DispenserMemory};
use crate::equipment::parking::ParkingMemory;
use crate::equipment::sensors::{self, Sensor};
use crate::equipment::site::{Site, Stream};
use crate::equipment::supply::{Supply, SupplyMemory, Way};

/// Largest increase of a counter that is a request. No cell has more objects, so a larger
/// increase means that the counter was set.
const MOST_REQUESTS: u32 = 1_000;

/// The devices of a cell.
pub(crate) struct Equipment {
    pub(crate) belt: Option<Belt>,
    pub(crate) supply: Option<Supply>,
    pub(crate) dispenser: Option<Dispenser>,
    pub(crate) sensors: Vec<Sensor>,
    /// An object below this height is taken out of the cell (m).
    pub(crate) clear_below: f64,
    /// Random numbers of the equipment.
    stream: Stream,
}

/// State of the devices: part of every snapshot.
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

/// The counters of [`ipc_types::decision::CellIo`] in the last decision.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Io {
    heard: bool,
    add_bin: u32,
    drop_parts: u32,
}

impl Io {
    /// New requests for bins and for drops. The first counters received are adopted, since the
    /// task may have counted before this physics started. So are counters that decreased or
    /// jumped: the task lost its record. A task that continues from its record requests as if
    /// it had never been killed.
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

/// Default height at which an object has left the cell: this far below the lowest shape at the
/// start (m).
// Without a bound in every cell an object fell to z = -100 m, and was then shown at its start.
const OUT_BELOW_M: f64 = 1.0;

impl Equipment {
    /// The equipment of a cell whose fixtures are in the engine.
    pub(crate) fn new(cell: &Cell, fixtures: &Fixtures) -> Self {
        let supply = cell.conveyor.as_ref().and_then(|c| c.supply.as_ref());
        Self {
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
            clear_below: (cell.clear_below_m).unwrap_or_else(|| lowest(cell) - OUT_BELOW_M),
            stream: Stream { seed: cell.seed },
        }
    }

    fn listens(&self) -> bool {
        self.belt.is_some() || self.dispenser.is_some()
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

    /// The counters of the task continue over a reset of the scene, as the task continues to
    /// count; requests that are still open are dropped.
    pub(crate) fn carry_over(&mut self, before: &Self) {
        self.io = before.io;
        self.decision_limit_ticks = before.decision_limit_ticks;
    }
}

impl Equipment {
    /// Runs the equipment before a step; returns the decision it obeyed.
    pub(crate) fn run(
        &self,
        memory: &mut EquipmentMemory,
        site: &mut Site<'_>,
        decision: Option<&Decision>,
    ) -> Option<Input> {
        // Before the requests, so that a device can bring an object that was disabled in this
        // tick.
        memory.parking.clear_fallen(site, self.clear_below);
        let obeyed = self.hear(memory, site.tick, decision);
        if let Some(belt) = self.running_belt(memory) {
            belt.wake(site);
        }
        if let Some(supply) = &self.supply {
            supply.run(&mut memory.supply, &mut self.way(site));
        }
        if let Some(dispenser) = &self.dispenser {
            dispenser.run(&mut memory.dispenser, site, self.stream);
        }
        obeyed
    }

    /// The access of a supply to the cell.
    pub(crate) fn way<'s, 'w>(&'s self, site: &'s mut Site<'w>) -> Way<'s, 'w> {
        Way {
            site,
            belt: self.belt.as_ref(),
            stream: self.stream,
        }
    }

    /// The hooks of the next step.
    pub(crate) fn hooks(&self, memory: &EquipmentMemory) -> Hooks {
        Hooks::new(self.running_belt(memory))
    }

    fn running_belt(&self, memory: &EquipmentMemory) -> Option<&Belt> {
        self.belt.as_ref().filter(|_| memory.running)
    }

    fn hear(
        &self,
        memory: &mut EquipmentMemory,
        tick: u64,
        decision: Option<&Decision>,
    ) -> Option<Input> {
        // The belt runs only while each tick confirms it: a task that died must not leave it
        // running.
        memory.running = false;
        let decision = decision.filter(|_| self.listens())?;
        // Requests count also from an old decision: only the belt has to stop with its task.
        let (bins, drops) = memory.io.take(decision);
        if self.supply.is_some() {
            memory.supply.ask(bins);
        }
        if let Some(dispenser) = &self.dispenser {
            let parts = drops.saturating_mul(dispenser.table.per_drop);
            memory.dispenser.ask(parts);
        }
        let age = tick.saturating_sub(decision.header.tick);
        if age > memory.decision_limit_ticks {
            return None;
        }
        memory.running = decision.io.conveyor_running == 1;
        Some(Input {
            topic: ipc_types::topic::TopicId::Decision.code(),
            generation: decision.header.generation,
            seq: decision.header.seq,
            age_ticks: age,
        })
    }

    /// The report of the equipment.
    pub(crate) fn report(
        &self,
        memory: &EquipmentMemory,
        engine: &PhysicsWorld,
        objects: &Objects,
    ) -> EquipmentState {
        let belt = self.running_belt(memory);
        EquipmentState {
            conveyor_speed: belt.map_or(0.0, |belt| belt.speed),
            bins_supplied: memory.supply.supplied,
            supply_refusals: memory.supply.refusals,
            supply_refusal: memory.supply.refusal,
            parts_dropped: memory.dispenser.dropped,
            parts_waiting: memory.dispenser.waiting,
            cleared: memory.parking.cleared,
            sensors: sensors::read(&self.sensors, engine, objects),
        }
    }
}

/// Lowest point of all that is in a cell at its start (m).
fn lowest(cell: &Cell) -> f64 {
    let bottom = |shape: &Shape, pose: &Isometry3<f64>| {
        let (shape, own) = shapes::shared(shape);
        shape.compute_aabb(&convert::to_pose(&(pose * own))).mins.z
    };
    let fixtures = cell.fixtures.iter().filter(|fixture| fixture.solid);
    let fixtures = fixtures.map(|fixture| bottom(&fixture.shape, &fixture.pose));
    let objects = cell.objects.iter().filter(|object| !object.parked);
    let objects = objects.map(|object| bottom(&object.shape, &object.pose));
    let bases = cell.arms.iter().map(|arm| arm.base.translation.z);
    fixtures.chain(objects).chain(bases).fold(0.0, f64::min)
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
        assert_eq!(take(1_017, 9), (0, 0), "set forward");
    }
}
