//! The matrix at work.

use std::sync::Arc;

use behavior::matrix::{Happening, Matrix};
use behavior::{Graph, NodeStatus};
use ipc_types::Text;
use ipc_types::decision::Outcome;
use serde::{Deserialize, Serialize};

use super::NAME;
use super::events::{self, Found};
use super::memory::Memory;
use super::names::State;
use super::paths;
use super::scene::{ARM, Scene};
use super::setup::BinStackSetup;
use super::supply;
use super::turn::Turn;
use crate::job::Job;
use crate::observation::Observation;
use crate::output::Output;
use crate::policy::Policy;
use crate::record;
use crate::ur10::{GripChange, Reached};

/// An arm nearer than this to its target is on its way, whatever happened (m).
const ON_THE_WAY_M: f64 = 0.25;

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct BinStack {
    setup: Arc<BinStackSetup>,
    matrix: Matrix,
    memory: Memory,
}

#[derive(Serialize, Deserialize)]
struct Record {
    #[serde(with = "serde_bytes")]
    matrix: Vec<u8>,
    memory: Memory,
}

impl BinStack {
    pub(super) fn new(setup: BinStackSetup) -> Self {
        Self {
            matrix: Matrix::new(Arc::clone(&setup.table)),
            setup: Arc::new(setup),
            memory: Memory::new(),
        }
    }

    fn state(&self) -> State {
        State::of(self.matrix.state())
    }

    /// Handles one event, and notes a new state.
    fn step(
        &mut self,
        scene: Scene<'_, '_>,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let now = observation.time();
        let state = self.state();
        let row = state.row(self.memory.opening());
        let found = Found {
            grip: self.memory.grip.update(scene.gripper),
            reached: self.memory.motion.step(&scene.tcp, row, now),
        };
        let pending = events::pending(state, &scene, &self.memory, job, found, now);
        let mut turn = Turn {
            scene,
            memory: &mut self.memory,
            job,
            out,
            found,
            now,
        };
        self.matrix.clear_trace();
        if let Err(wrong) = self.matrix.tick(pending, &mut turn) {
            out.log(format_args!("[fault] {wrong}"));
        }
        self.note_change(observation, job, out);
    }

    /// Says which state was left for which, and why.
    fn note_change(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        for happening in self.matrix.trace() {
            let Happening::Changed { from, to, event } = *happening else {
                continue;
            };
            let table = self.matrix.table();
            let event = table.event_name(event);
            let node = |id: behavior::machine::StateId| (0, usize::from(id.0));
            out.status(node(from), NodeStatus::Running, NodeStatus::Invalid, event);
            out.status(node(to), NodeStatus::Invalid, NodeStatus::Running, event);
            let (from, to) = (table.state_name(from), table.state_name(to));
            out.transition(format_args!("{from} -> {to} ({event})"));
            self.memory.since = observation.time();
            job.counters.phase_entry += 1;
        }
    }

    fn report(&self, scene: Scene<'_, '_>, job: &mut Job, out: &mut Output) {
        job.placed.clear();
        for bin in scene.stacked() {
            if job.placed.len() < ipc_types::decision::MAX_PLACED {
                job.placed
                    .push(u32::try_from(bin.object).unwrap_or(u32::MAX));
            }
        }
        let idle = self.state() == State::Standby && !self.memory.motion.is_moving();
        let still = scene.stacked().all(|bin| bin.still);
        let done = job.started && idle && still && job.placed.len() >= self.setup.wanted;
        if done && !job.done {
            out.log(format_args!(
                "[decide] -> all {} bins stacked",
                job.placed.len()
            ));
        }
        job.done = done;
        out.phase = self.phase();
        out.outcome = match (job.done, job.started) {
            (true, _) => Outcome::Done,
            (false, true) => Outcome::Running,
            (false, false) => Outcome::Idle,
        };
    }

    /// Goes on from what is seen: a bin in the hand, or none.
    fn begin_from(
        &mut self,
        scene: Scene<'_, '_>,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let held = scene.held();
        let mut turn = Turn {
            scene,
            memory: &mut self.memory,
            job,
            out,
            found: Found {
                grip: GripChange::default(),
                reached: Reached::Nothing,
            },
            now: observation.time(),
        };
        let next = if let Some(bin) = held {
            let name = scene.setup.name(bin.object);
            turn.out.log(format_args!("[resume] {name} is in the hand"));
            turn.choose_way()
        } else {
            turn.job.held = None;
            turn.go_home()
        };
        if let behavior::matrix::Next::Goto(state) = next {
            self.matrix.set_state(state);
            self.memory.since = observation.time();
            job.counters.phase_entry += 1;
        }
    }

    /// Whether what is remembered can go on as it is: the arm is where it was
    /// sent, and the hand holds what it should.
    fn goes_on(&self, scene: &Scene<'_, '_>, observation: &Observation<'_>) -> bool {
        let target = self.memory.motion.target(observation.time());
        let target = target.unwrap_or_else(|| paths::rest(&self.setup));
        let offset =
            nalgebra::Vector3::from(target.position) - nalgebra::Vector3::from(scene.tcp.position);
        if offset.norm() > ON_THE_WAY_M {
            return false;
        }
        let attached = scene.gripper.attached == 1;
        match self.state() {
            State::Standby | State::Picking => !attached,
            State::Attach => true,
            State::Placing | State::Flipping => attached,
            State::Detach => attached || self.memory.opening(),
        }
    }
}

impl Policy for BinStack {
    fn name(&self) -> &'static str {
        NAME
    }

    fn reset(&mut self) {
        self.matrix = Matrix::new(Arc::clone(&self.setup.table));
        self.memory = Memory::new();
    }

    fn tick(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = Scene::read(&setup, observation) else {
            return;
        };
        self.step(scene, observation, job, out);
        supply::update(
            &scene,
            &mut self.memory.supply,
            job,
            out,
            observation.time(),
        );
        let selector = u32::from(self.matrix.state().0);
        let gripper = self.memory.gripper();
        let intent = self
            .memory
            .motion
            .intent(gripper, selector, observation.time());
        out.arm(ARM, intent);
        self.report(scene, job, out);
    }

    fn phase(&self) -> Text<32> {
        Text::new(self.matrix.state_name())
    }

    fn describe(&self) -> Vec<Graph> {
        vec![self.matrix.describe()]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        out.extend(self.matrix.statuses());
    }

    fn save(&self) -> Vec<u8> {
        let mut matrix = Vec::with_capacity(self.matrix.record_bytes());
        self.matrix.save(&mut matrix);
        record::to_bytes(&Record {
            matrix,
            memory: self.memory.clone(),
        })
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let record: Record = record::from_bytes(bytes)?;
        let unusable = |what: &str| Err(bincode::ErrorKind::Custom(what.to_owned()).into());
        if !record.memory.is_sound(self.setup.names.len()) {
            return unusable("the record is of another cell");
        }
        if self.matrix.restore(&record.matrix).is_err() {
            return unusable("the record's state is not in the matrix");
        }
        self.memory = record.memory;
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = Scene::read(&setup, observation) else {
            return;
        };
        if !self.goes_on(&scene, observation) {
            self.begin_from(scene, observation, job, out);
        }
    }
}
