//! The world: one pure step per tick.
//!
//! [`World::step`] is a function of the state, the commands and the decision: it reads no
//! clock, file or port. Runs are compared by the hash of the state to the bit, after kills and
//! in a replay as well, so a change must keep these rules:
//!
//! - All that decides the next tick is in the engine or in `Memory`, which are the snapshot.
//!   A value kept elsewhere is lost at a kill, and the run then differs from one without a
//!   kill.
//! - The order of insertion of bodies is the order in which the solver handles joints and
//!   contacts. Another order gives other last bits.
//! - The order within a step: drives and cups, equipment, drags, engine, tick, faults, cups,
//!   measurement, counts. Forces and joints are set before the engine runs; loads and contacts
//!   are read after it.
//! - The engine may disable a body, or panic when a driven joint is not finite. Both make the
//!   arm faulty, which removes power from its drives, and neither ends the process: a reset of
//!   the scene has to remain possible.
//! - A body is borrowed for change only where it changes: the engine examines each such body
//!   again, and a sleeping pile would cost as much as an awake one.

use std::panic::{AssertUnwindSafe, catch_unwind};

use cell_model::Cell;
use ipc_types::operator::{OperatorAction, ReplyCode};
use ipc_types::{ArmCommand, Decision, MAX_ARMS, OperatorRequest, TICK_NS, WorldState};
use rapier3d_f64::prelude::*;

use crate::arm::drive::{self, ArmDrive};
use crate::arm::measured::{Measured, finite_tcp};
use crate::arm::multibody::Arm;
use crate::arm::touch_count::TouchCounter;
use crate::arm::touches::{self, ArmContact};
pub use crate::error::WorldError;

use crate::engine::contacts::{self, Contacts};
use crate::engine::objects::{self, Objects};
use crate::engine::{awake, convert, entered, settings, spawn};
use crate::equipment::devices::Equipment;
use crate::equipment::site::Site;
use crate::gripper::cups::Cups;
use crate::gripper::momentum::Velocities;
use crate::gripper::suction;
use crate::operator::drag;
use crate::operator::requests::{self, Desk};
use crate::state::memory::Memory;
use crate::state::message::View;
use crate::state::{snapshot, touching};

mod faults;
mod restore;

/// Input of one tick.
#[derive(Clone, Copy, Default)]
pub struct StepInput<'a> {
    /// Newest accepted command of each arm, of any age.
    pub commands: [Option<&'a ArmCommand>; MAX_ARMS],
    /// Newest decision, for the cell's equipment.
    pub decision: Option<&'a Decision>,
}

/// The robot and the world.
pub struct World {
    pub(crate) engine: PhysicsWorld,
    pub(crate) objects: Objects,
    pub(crate) equipment: Equipment,
    pub(crate) arms: Vec<Arm>,
    /// By arm: its drives.
    pub(crate) drives: Vec<ArmDrive>,
    /// By arm: its measured joints.
    pub(crate) measured: Vec<Measured>,
    pub(crate) contacts: Contacts,
    touch_counter: TouchCounter,
    /// Velocities of the objects before the last step, while a cup holds one.
    before: Velocities,
    /// State outside of the engine that decides the next tick.
    pub(crate) memory: Memory,
    /// Messages the present state was computed from.
    inputs: Vec<ipc_types::Input>,
    /// Snapshot of the start.
    initial: Vec<u8>,
    /// A reset of the task leaves it paused.
    reset_pauses: bool,
    /// Same for the same cell and program: stamps snapshots.
    fingerprint: u64,
}

impl World {
    /// Sets the scene up at tick 0.
    ///
    /// # Errors
    /// [`WorldError`] where something overlaps or does not fit.
    pub fn new(cell: &Cell) -> Result<Self, WorldError> {
        spawn::check(cell)?;
        too_many("arms", cell.arms.len(), MAX_ARMS)?;
        too_many("objects", cell.objects.len(), ipc_types::MAX_OBJECTS)?;
        for arm in &cell.arms {
            too_many(
                "controlled joints",
                arm.robot.arm_joints.len(),
                ipc_types::MAX_JOINTS,
            )?;
        }
        let mut engine = settings::empty_world();
        let fixtures = objects::insert_fixtures(&mut engine, cell);
        // Arms are inserted first: objects that fall asleep and wake change the order of the
        // bodies after them, and the solver handles the rows of joints in the order of the
        // bodies.
        let specs = cell.arms.iter().enumerate();
        let arms: Vec<Arm> = specs
            .map(|(index, spec)| Arm::insert(&mut engine, index, spec))
            .collect();
        let objects = Objects::insert(&mut engine, cell);
        // The engine cannot part a link from a fixture that it starts inside of: without this
        // the arm is faulty from the first ticks, or is held by the contact.
        entered::let_through(&mut engine, cell, &fixtures, &arms);
        let equipment = Equipment::new(cell, &fixtures);
        if let Some(belt) = &equipment.belt {
            belt.drive_contacts(&mut engine);
        }
        let mut world = Self {
            equipment,
            memory: Memory::new(cell),
            before: Velocities::default(),
            contacts: Contacts::new(arms.len(), objects.bodies.len()),
            touch_counter: TouchCounter::new(cell),
            measured: arms.iter().map(|arm| Measured::new(&arm.robot)).collect(),
            drives: (cell.arms.iter())
                .map(|arm| ArmDrive::new(arm, &cell.disturbance))
                .collect(),
            inputs: Vec::new(),
            initial: Vec::new(),
            reset_pauses: cell.reset_pauses,
            fingerprint: snapshot::fingerprint(cell),
            engine,
            arms,
            objects,
        };
        // The snapshot of the start is taken last: a reset decodes it, so anything inserted
        // after it would be missing in the scene after a reset.
        world.read_back();
        world.initial = world.snapshot();
        Ok(world)
    }

    /// Simulates one tick.
    pub fn step(&mut self, input: &StepInput<'_>) {
        self.inputs.clear();
        // Drives and cups work even if the engine is broken: the watchdog has to account for
        // each command, and a cup has to release.
        self.drive_arms(&input.commands);
        // A broken engine has numbers that are not finite; equipment would place objects by
        // them.
        if !self.memory.broken {
            let memory = &mut self.memory.equipment;
            let mut site = Site {
                engine: &mut self.engine,
                objects: &self.objects,
                drags: &mut self.memory.drags,
                arms: &self.memory.arms,
                tick: self.memory.tick,
            };
            let obeyed = self.equipment.run(memory, &mut site, input.decision);
            self.inputs.extend(obeyed);
        }
        drag::pull(&mut self.engine, &self.objects, &mut self.memory.drags);
        let mut arms = self.memory.arms.iter();
        // Velocities before the step are needed only for the load on a cup; without one the
        // copy of all objects is not worth its time.
        if arms.any(|arm| arm.suction.attached().is_some()) {
            self.before.note(&self.engine, &self.objects.bodies);
        }
        self.step_engine();
        // The tick counts also without an engine step, so that time passes for readers of a
        // broken scene and their ages grow.
        self.memory.tick += 1;
        self.read_quarantine();
        // Cups are read before the contacts: a grip that breaks in this tick must not count as
        // a touched object.
        self.cups().read();
        self.read_back();
        self.count_outside();
        self.touch_counter.count_all(
            &self.engine,
            &self.arms,
            &self.measured,
            &self.contacts.grips,
            &mut self.memory,
        );
    }

    fn drive_arms(&mut self, commands: &[Option<&ArmCommand>; MAX_ARMS]) {
        let (tick, broken) = (self.memory.tick, self.memory.broken);
        let drives = self.drives.iter_mut().zip(&mut self.memory.arms);
        let arms = self.arms.iter().zip(&self.measured).zip(commands);
        for (index, ((drive, memory), (arm, command))) in drives.zip(arms).enumerate() {
            let engine = &mut self.engine;
            drive.joints(engine, arm, memory, (tick, *command));
            drive.fingers(engine, arm, memory);
            let suction = &mut memory.suction;
            suction::switch(engine, (index, arm.0), &self.objects, suction, broken);
            self.inputs.extend(drive::input(index, memory, tick));
        }
    }

    /// All that the state message contains.
    fn view(&self) -> View<'_> {
        View {
            engine: &self.engine,
            objects: &self.objects,
            equipment: &self.equipment,
            arms: &self.arms,
            drives: &self.drives,
            measured: &self.measured,
            contacts: &self.contacts,
            memory: &self.memory,
            inputs: &self.inputs,
        }
    }

    fn cups(&mut self) -> Cups<'_> {
        Cups {
            engine: &mut self.engine,
            arms: &self.arms,
            memory: &mut self.memory.arms,
            objects: &self.objects,
            before: &self.before,
        }
    }

    /// The engine panics when a driven joint stops being finite. Every arm is then faulty and
    /// the scene stays at rest until a reset, which replaces the engine.
    fn step_engine(&mut self) {
        if self.memory.broken {
            return;
        }
        let hooks = self.equipment.hooks(&self.memory.equipment);
        let engine = &mut self.engine;
        let step = AssertUnwindSafe(|| engine.step_with_events(&hooks, &()));
        if catch_unwind(step).is_err() {
            // The engine may be in any state after a panic: it is not stepped again, only
            // replaced.
            self.memory.broken = true;
            self.memory.quarantined += 1;
            for arm in &mut self.memory.arms {
                arm.watchdog.fault = true;
            }
        }
    }

    /// Reads joints and contacts back from the engine.
    fn read_back(&mut self) {
        let arms = self.arms.iter().zip(&mut self.measured);
        for ((arm, measured), memory) in arms.zip(&mut self.memory.arms) {
            let fault = &mut memory.watchdog.fault;
            // A fault is never cleared here: only a reset, which replaces the engine, ends it.
            *fault = *fault || !measured.read(arm, &self.engine);
        }
        let memory = &self.memory;
        if memory.broken {
            return;
        }
        self.contacts.read(&self.engine, &self.arms);
        for arm in &memory.arms {
            self.contacts.attach(arm.suction.attached());
        }
        // Contacts decide which objects may sleep, so they are read before.
        awake::wake_touched(&mut self.engine, &self.objects, &self.contacts);
    }

    /// Executes a request of the operator. Pause, resume, step, script and end are refused
    /// here: they belong to the process around the world.
    pub fn operate(
        &mut self,
        action: OperatorAction,
        request: &OperatorRequest,
    ) -> (ReplyCode, String) {
        // A reset replaces the engine, which the borrows of the other requests would forbid.
        if action == OperatorAction::Reset {
            let reset = self.reset();
            return requests::answer_to(reset, self.memory.panel.task_paused);
        }
        let mut desk = Desk {
            engine: &mut self.engine,
            objects: &self.objects,
            equipment: &self.equipment,
            arms: &self.arms,
            measured: &self.measured,
            memory: &mut self.memory,
            reset_pauses: self.reset_pauses,
        };
        desk.act(action, request)
    }

    /// Whether the operator leads the arms: the task is paused.
    pub(crate) fn operator_leads(&self) -> bool {
        self.memory.panel.task_paused
    }

    /// Last orientation requested by the operator for `arm`, or else the present one of its
    /// tool (w, x, y, z); `None` if the cell has no arm of that index.
    pub(crate) fn present_orientation(&self, arm: u32) -> Option<[f64; 4]> {
        let panel = &self.memory.panel;
        if panel.target_seq > 0 && panel.target_arm == arm {
            return Some(panel.target_orientation_wxyz);
        }
        let index = arm as usize;
        let (arm, measured) = self.arms.get(index).zip(self.measured.get(index))?;
        let tcp = finite_tcp(&self.engine, arm, measured);
        Some(convert::to_wire(&tcp).orientation_wxyz)
    }

    /// Decisions older than this stop the belt, as they stop the arms (ticks).
    pub fn set_decision_limit(&mut self, ticks: u64) {
        self.memory.equipment.decision_limit_ticks = ticks;
    }

    /// Writes the present state; the publisher adds run, generation, seq and
    /// time, the process flags and script.
    pub fn write_state(&self, out: &mut WorldState) {
        self.view().write(out);
    }

    /// Writes the contacts of the present state.
    pub fn write_contacts(&self, out: &mut ipc_types::Contacts) {
        touching::write(&self.engine, self.memory.tick, out);
    }

    /// Hash over bodies, joints and tick: equal for equal runs.
    pub fn state_hash(&self) -> u64 {
        self.view().state_hash()
    }

    /// Tick of the present state; 0 at the start.
    pub fn tick(&self) -> u64 {
        self.memory.tick
    }

    /// Simulated time of the present state (ns).
    pub fn sim_time_ns(&self) -> u64 {
        self.memory.tick * TICK_NS
    }

    /// Commands refused since the start: too far from the setpoint in force, or
    /// with implausible numbers.
    pub fn refused_commands(&self) -> u64 {
        let arms = self.memory.arms.iter();
        arms.map(|arm| arm.watchdog.refused).sum()
    }

    /// Deepest penetration of any two shapes in contact (m).
    pub fn penetration(&self) -> f64 {
        contacts::deepest(&self.engine)
    }

    /// Wakes all objects at rest, to measure their cost when awake.
    pub fn wake_objects(&mut self) {
        for body in &self.objects.bodies {
            self.engine.wake_up(*body, true);
        }
    }

    /// Contacts of the links of an arm in the present state, except those of its base; empty
    /// if the cell has no arm of that index.
    pub fn arm_contacts(&self, arm: usize) -> Vec<ArmContact> {
        let spec = self.arms.get(arm);
        spec.map_or_else(Vec::new, |spec| touches::of(&self.engine, arm, spec))
    }
}

fn too_many(what: &'static str, count: usize, limit: usize) -> Result<(), WorldError> {
    if count <= limit {
        Ok(())
    } else {
        Err(WorldError::TooMany { what, count, limit })
    }
}
