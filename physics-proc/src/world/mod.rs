//! The world: one pure step per tick.
//!
//! [`World::step`] is a function of the state, the commands and the decision: it reads no
//! clock, file or port. Runs are compared by the hash of the state to the bit, after kills and
//! in a replay as well, so a change must keep these rules:
//!
//! - Each component (engine, arms, grippers, equipment, operator) keeps what decides the next
//!   tick in the part that it saves. A value kept elsewhere is lost at a kill, and the run then
//!   differs from one without a kill.
//! - The order of insertion of bodies is the order in which the solver handles joints and
//!   contacts. Another order gives other last bits.
//! - Forces, targets and joints are set before the engine runs; loads and contacts are read
//!   after it. [`World::step`] has the reason for the place of each component.
//! - The engine may disable a body, or panic when a driven joint is not finite. Both make the
//!   arm faulty, which removes power from its drives, and neither ends the process: a reset of
//!   the scene has to remain possible.
//! - A body is borrowed for change only where it changes: the engine examines each such body
//!   again, and a sleeping pile would cost as much as an awake one.

use cell_model::Cell;
use ipc_types::{ArmCommand, Decision, MAX_ARMS, TICK_NS};

use crate::arm::arms::Arms;
use crate::arm::touches::ArmContact;
pub use crate::error::WorldError;

use crate::engine::objects::{self, Objects};
use crate::engine::simulation::Engine;
use crate::engine::{contacts, convert, entered, settings, spawn};
use crate::equipment::devices::Equipment;
use crate::gripper::grippers::Grippers;
use crate::operator::requests::Operator;
use crate::state::snapshot;

mod message;
mod requests;
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
    tick: u64,
    engine: Engine,
    arms: Arms,
    grippers: Grippers,
    equipment: Equipment,
    operator: Operator,
    /// Messages the present state was computed from.
    inputs: Vec<ipc_types::Input>,
    /// Snapshot of the start.
    initial: Vec<u8>,
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
        let mut rapier = settings::empty_world();
        let fixtures = objects::insert_fixtures(&mut rapier, cell);
        // Arms are inserted first: objects that fall asleep and wake change the order of the
        // bodies after them, and the solver handles the rows of joints in the order of the
        // bodies.
        let arms = Arms::insert(&mut rapier, cell);
        let objects = Objects::insert(&mut rapier, cell);
        // The engine cannot part a link from a fixture that it starts inside of: without this
        // the arm is faulty from the first ticks, or is held by the contact.
        entered::let_through(&mut rapier, cell, &fixtures, arms.bodies());
        let mut world = Self {
            tick: 0,
            equipment: Equipment::new(&mut rapier, cell, &fixtures),
            engine: Engine::new(rapier, objects),
            arms,
            grippers: Grippers::new(cell),
            operator: Operator::new(cell.reset_pauses),
            inputs: Vec::new(),
            initial: Vec::new(),
            fingerprint: snapshot::fingerprint(cell),
        };
        // The snapshot of the start is taken last: a reset decodes it, so anything inserted
        // after it would be missing in the scene after a reset.
        world.measure();
        world.initial = world.snapshot();
        Ok(world)
    }

    /// See [`Engine::make_ideal`].
    pub(crate) fn make_ideal(&mut self) {
        self.engine.make_ideal();
    }

    /// Simulates one tick.
    pub fn step(&mut self, input: &StepInput<'_>) {
        let (tick, engine) = (self.tick, &mut self.engine);
        // Arms first, also if the engine is broken: their watchdogs decide which commands count,
        // and have to account for each.
        let accepted = self.arms.before_step(engine, tick, &input.commands);
        self.inputs.clear();
        self.inputs.extend(self.arms.inputs(tick));
        // Grippers after the arms, whose watchdogs accepted the commands; before the equipment,
        // which leaves objects on a cup in the cell.
        self.grippers.before_step(engine, &self.arms, &accepted);
        // Equipment before the drags: it ends the drag of an object that it takes out of the
        // cell.
        let decision = (tick, input.decision);
        let drags = self.operator.drags_mut();
        let followed = self
            .equipment
            .before_step(engine, &self.grippers, drags, decision);
        self.inputs.extend(followed);
        // Drags last of all forces: they act on the objects that are in the cell in this tick.
        self.operator.before_step(engine);
        // Velocities after all that sets them: the load on a cup is their change by the engine.
        self.grippers.note_velocities(engine);
        // The engine integrates the targets, joints and forces that were set above.
        engine.step(&self.equipment.hooks());
        // The tick counts also without an engine step, so that time passes for readers of a
        // broken scene and their ages grow.
        self.tick += 1;
        // Arms first after the engine, so that a body that it disabled makes its arm faulty in
        // this tick.
        self.arms.after_step(engine);
        // Grippers before the counts: a load may break a grip, and its object then counts as not
        // held.
        self.grippers.after_step(engine, &self.arms);
        // The operator after the grippers: what an arm holds does not press on it.
        let grippers = &self.grippers;
        let held = |arm| grippers.held(arm);
        self.operator.after_step(&self.engine, &self.arms, held);
        // Counts last: they leave out faulty arms, and the object that a gripper holds.
        self.arms.count(&self.engine, self.tick, held);
    }

    /// Whether the operator leads the arms: the task is paused.
    pub(crate) fn operator_leads(&self) -> bool {
        self.operator.task_is_paused()
    }

    /// Last orientation requested by the operator for `arm`, or else the present one of its
    /// tool (w, x, y, z); `None` if the cell has no arm of that index.
    pub(crate) fn present_orientation(&self, arm: u32) -> Option<[f64; 4]> {
        let requested = self.operator.target_orientation(arm);
        let present = || {
            let tcp = self.arms.tcp(&self.engine, arm as usize)?;
            Some(convert::to_wire(&tcp).orientation_wxyz)
        };
        requested.or_else(present)
    }

    /// Decisions older than this stop the belt, as they stop the arms (ticks).
    pub fn set_decision_limit(&mut self, ticks: u64) {
        self.equipment.set_decision_limit(ticks);
    }

    /// Tick of the present state; 0 at the start.
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// Simulated time of the present state (ns).
    pub fn sim_time_ns(&self) -> u64 {
        self.tick * TICK_NS
    }

    /// Commands refused since the start: too far from the setpoint in force, or
    /// with implausible numbers.
    pub fn refused_commands(&self) -> u64 {
        self.arms.refused_commands()
    }

    /// Number of faulty arms.
    pub fn faults(&self) -> usize {
        self.arms.faults()
    }

    /// The reason of each faulty arm, one line each; empty if no arm is faulty.
    pub fn fault_words(&self) -> String {
        self.arms.fault_words()
    }

    /// Number of objects that fell out of the cell and that only a reset brings back.
    pub fn lost(&self) -> usize {
        self.equipment.lost().0.len()
    }

    /// Names of the lost objects after the first `known`; empty where there are none.
    pub fn lost_words(&self, known: usize) -> String {
        let (lost, below) = self.equipment.lost();
        let lost = lost.iter().skip(known);
        let names = lost.filter_map(|object| self.engine.specs().get(*object));
        let names: Vec<String> = names.map(|spec| format!("'{}'", spec.name)).collect();
        if names.is_empty() {
            return String::new();
        }
        format!(
            "below z = {below:.2} m an object is out of the cell until a reset: {}",
            names.join(", ")
        )
    }

    /// Deepest penetration of any two shapes in contact (m).
    pub fn penetration(&self) -> f64 {
        contacts::deepest(self.engine.rapier())
    }

    /// Wakes all objects at rest, to measure their cost when awake.
    pub fn wake_objects(&mut self) {
        self.engine.wake_all();
    }

    /// Contacts of the links of an arm in the present state, except those of its base; empty
    /// if the cell has no arm of that index.
    pub fn arm_contacts(&self, arm: usize) -> Vec<ArmContact> {
        self.arms.contacts(&self.engine, arm)
    }

    /// The engine and the arms, for tests that break them.
    #[cfg(test)]
    pub(crate) fn engine_and_arms(&mut self) -> (&mut Engine, &mut Arms) {
        (&mut self.engine, &mut self.arms)
    }
}

fn too_many(what: &'static str, count: usize, limit: usize) -> Result<(), WorldError> {
    if count <= limit {
        Ok(())
    } else {
        Err(WorldError::TooMany { what, count, limit })
    }
}
