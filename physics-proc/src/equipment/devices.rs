//! The equipment as a component of the world: its devices, and the requests to them.

use cell_model::stop::DECISION_AGE_FIFO_TICKS;
use cell_model::{Cell, Shape};
use ipc_types::operator::ReplyCode;
use ipc_types::{Decision, EquipmentState, Input};
use nalgebra::Isometry3;
use rapier3d_f64::prelude::PhysicsWorld;
use serde::{Deserialize, Serialize};

use crate::engine::hooks::Hooks;
use crate::engine::objects::Fixtures;
use crate::engine::simulation::Engine;
use crate::engine::{convert, shapes};
use crate::equipment::conveyor::Belt;
use crate::equipment::dispenser::{Dispenser, DispenserState};
use crate::equipment::parking::Parking;
use crate::equipment::sensors::{self, Sensor};
use crate::equipment::stream::Stream;
use crate::equipment::supply::{Supply, SupplyState, Surroundings};
use crate::gripper::grippers::Grippers;
use crate::operator::drag::Drags;
use crate::operator::requests::Reply;

/// Largest increase of a counter that is a request. No cell has more objects, so a larger
/// increase means that the counter was set.
const MOST_REQUESTS: u32 = 1_000;

/// The devices of a cell.
pub(crate) struct Equipment {
    belt: Option<Belt>,
    supply: Option<Supply>,
    dispenser: Option<Dispenser>,
    sensors: Vec<Sensor>,
    /// An object below this height is taken out of the cell (m).
    clear_below: f64,
    /// Random numbers of the equipment.
    stream: Stream,
    state: DeviceStates,
    /// Decisions about earlier states are about the scene before a reset. Not part of a snapshot:
    /// a successor of physics hears no decision of before.
    first_tick: u64,
}

/// State of the devices: part of every snapshot.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct DeviceStates {
    counters: TaskCounters,
    /// The belt runs in this tick.
    running: bool,
    /// Decisions older than this stop the belt (ticks).
    decision_limit_ticks: u64,
    supply: SupplyState,
    dispenser: DispenserState,
    parking: Parking,
}

/// The counters of [`ipc_types::decision::CellIo`] in the last decision.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct TaskCounters {
    is_known: bool,
    add_bin: u32,
    drop_parts: u32,
}

impl TaskCounters {
    /// New requests for bins and for drops. The first counters received are adopted, since the
    /// task may have counted before this physics started. So are counters that decreased or
    /// jumped: the task lost its record. A task that continues from its record requests as if
    /// it had never been killed.
    fn update(&mut self, decision: &Decision) -> (u32, u32) {
        let known = std::mem::replace(&mut self.is_known, true);
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

impl DeviceStates {
    /// At the start of a run.
    fn new() -> Self {
        Self {
            counters: TaskCounters::default(),
            running: false,
            decision_limit_ticks: DECISION_AGE_FIFO_TICKS,
            supply: SupplyState::default(),
            dispenser: DispenserState::default(),
            parking: Parking::default(),
        }
    }
}

impl Equipment {
    /// The equipment of a cell whose fixtures are in the engine.
    pub(crate) fn new(rapier: &mut PhysicsWorld, cell: &Cell, fixtures: &Fixtures) -> Self {
        let conveyor = cell.conveyor.as_ref();
        let supply = conveyor.and_then(|conveyor| conveyor.supply.as_ref());
        let dispenser = cell.dispenser.as_ref();
        let belt = conveyor.and_then(|table| Belt::new(table, cell, fixtures));
        if let Some(belt) = &belt {
            belt.drive_contacts(rapier);
        }
        Self {
            belt,
            supply: supply.map(|table| Supply::new(table, cell)),
            dispenser: dispenser.map(|table| Dispenser::new(table, cell)),
            sensors: cell.sensors.iter().map(Sensor::new).collect(),
            clear_below: (cell.clear_below_m).unwrap_or_else(|| lowest(cell) - OUT_BELOW_M),
            stream: Stream { seed: cell.seed },
            state: DeviceStates::new(),
            first_tick: 0,
        }
    }

    /// Runs the devices; returns the decision that the belt follows. Devices of a broken engine
    /// do nothing: its numbers are not finite, and objects would be placed by them.
    pub(crate) fn before_step(
        &mut self,
        engine: &mut Engine,
        grippers: &Grippers,
        drags: &mut Drags,
        (tick, decision): (u64, Option<&Decision>),
    ) -> Option<Input> {
        if engine.is_broken() {
            return None;
        }
        // Before the requests, so that a device can bring an object that was disabled in this
        // tick.
        let parking = &mut self.state.parking;
        parking.clear_fallen(engine, grippers, drags, self.clear_below);
        let followed = self.take_requests(tick, decision);
        if let Some(belt) = self.running_belt() {
            belt.wake(engine);
        }
        if let Some(supply) = &self.supply {
            let mut cell = Surroundings {
                engine,
                grippers,
                belt: self.belt.as_ref(),
                stream: self.stream,
                tick,
            };
            supply.before_step(&mut self.state.supply, &mut cell);
        }
        if let Some(dispenser) = &self.dispenser {
            dispenser.before_step(&mut self.state.dispenser, engine, tick, self.stream);
        }
        followed
    }

    /// The hooks of the next step.
    pub(crate) fn hooks(&self) -> Hooks {
        Hooks::new(self.running_belt().map(Belt::surface))
    }

    fn running_belt(&self) -> Option<&Belt> {
        self.belt.as_ref().filter(|_| self.state.running)
    }

    fn take_requests(&mut self, tick: u64, decision: Option<&Decision>) -> Option<Input> {
        let state = &mut self.state;
        // The belt runs only while each tick confirms it: a task that died must not leave it
        // running.
        state.running = false;
        let has_devices = self.belt.is_some() || self.dispenser.is_some();
        let decision = decision.filter(|_| has_devices)?;
        // Requests count also from an old decision: only the belt has to stop with its task.
        let (bins, drops) = state.counters.update(decision);
        // A decision about the scene before a reset: what it asks for is counted, and not done.
        if decision.header.tick < self.first_tick {
            return None;
        }
        if self.supply.is_some() {
            state.supply.request(bins);
        }
        if let Some(dispenser) = &self.dispenser {
            let parts = drops.saturating_mul(dispenser.table.per_drop);
            state.dispenser.request(parts);
        }
        let age = tick.saturating_sub(decision.header.tick);
        if age > state.decision_limit_ticks {
            return None;
        }
        state.running = decision.io.conveyor_running == 1;
        Some(Input {
            topic: ipc_types::topic::TopicId::Decision.code(),
            generation: decision.header.generation,
            seq: decision.header.seq,
            age_ticks: age,
        })
    }

    /// Decisions older than this stop the belt (ticks).
    pub(crate) fn set_decision_limit(&mut self, ticks: u64) {
        self.state.decision_limit_ticks = ticks;
    }

    /// Drops parts for the operator, as soon as they are due; 0 is one drop.
    ///
    /// # Errors
    /// The answer where they cannot be dropped.
    pub(crate) fn drop_parts(&mut self, engine: &Engine, parts: u32) -> Result<(), Reply> {
        let Some(dispenser) = &self.dispenser else {
            let message = "this cell has no dispenser".to_owned();
            return Err((ReplyCode::NotInThisCell, message));
        };
        let per_drop = dispenser.table.per_drop;
        let parts = if parts == 0 { per_drop } else { parts };
        // Counted before the request is accepted, so that the answer is true.
        let left = dispenser.parts_left(&self.state.dispenser, engine);
        if left == 0 {
            let message = "no part is left; a reset of the scene brings them back".to_owned();
            return Err((ReplyCode::OutOfRange, message));
        }
        if parts > left {
            let message = format!("{parts} parts were asked for and {left} are left");
            return Err((ReplyCode::OutOfRange, message));
        }
        self.state.dispenser.request(parts);
        Ok(())
    }

    /// Brings a bin for the operator in this tick.
    ///
    /// # Errors
    /// The answer where no bin can be brought.
    pub(crate) fn add_bin(
        &mut self,
        engine: &mut Engine,
        grippers: &Grippers,
        (tick, flipped): (u64, bool),
    ) -> Result<(), Reply> {
        let Some(supply) = &self.supply else {
            let message = "this cell has no conveyor that brings bins".to_owned();
            return Err((ReplyCode::NotInThisCell, message));
        };
        let mut cell = Surroundings {
            engine,
            grippers,
            belt: self.belt.as_ref(),
            stream: self.stream,
            tick,
        };
        let state = &mut self.state.supply;
        let added = supply.add(state, &mut cell, flipped);
        added.map_err(|why| (ReplyCode::OutOfRange, supply.refusal(why, state, tick)))
    }

    /// The report of the equipment.
    pub(crate) fn report(&self, engine: &Engine) -> EquipmentState {
        let (belt, state) = (self.running_belt(), &self.state);
        EquipmentState {
            conveyor_speed: belt.map_or(0.0, |belt| belt.speed),
            bins_supplied: state.supply.supplied,
            supply_refusals: state.supply.refusals,
            supply_refusal: state.supply.refusal,
            parts_dropped: state.dispenser.dropped,
            parts_waiting: state.dispenser.waiting,
            cleared: state.parking.cleared,
            sensors: sensors::read(&self.sensors, engine),
        }
    }

    /// Objects that fell out and that only a reset brings back, and the height below which an
    /// object is taken out (m).
    pub(crate) fn lost(&self) -> (&[usize], f64) {
        (&self.state.parking.lost, self.clear_below)
    }

    /// Its part of a snapshot.
    pub(crate) fn save(&self) -> &DeviceStates {
        &self.state
    }

    /// Continues from a snapshot.
    pub(crate) fn restore(&mut self, saved: DeviceStates) {
        self.state = saved;
    }

    /// Back to the start. The counters of the task continue, as the task continues to count;
    /// requests that are still open are dropped, and counts of the scene (bins, parts) start
    /// from 0. Decisions about `tick` and earlier ones are about the scene before.
    pub(crate) fn reset(&mut self, initial: DeviceStates, tick: u64) {
        self.first_tick = tick + 1;
        self.state = DeviceStates {
            counters: self.state.counters,
            decision_limit_ticks: self.state.decision_limit_ticks,
            ..initial
        };
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
        let mut counters = TaskCounters::default();
        let mut take = |add_bin, drop_parts| counters.update(&decision(add_bin, drop_parts));
        assert_eq!(take(5, 7), (0, 0), "heard first");
        assert_eq!(take(5, 7), (0, 0), "said again");
        assert_eq!(take(6, 9), (1, 2));
        assert_eq!(take(0, 9), (0, 0), "a task without its record");
        assert_eq!(take(16, 9), (16, 0));
        assert_eq!(take(1_017, 9), (0, 0), "set forward");
    }
}
