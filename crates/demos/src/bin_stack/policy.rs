//! The matrix at work.

use robocell_task::TraceEvent;
use std::sync::Arc;

use behavior::{Graph, NodeStatus};
use ipc_types::Text;
use ipc_types::decision::Outcome;

use super::events;
use super::memory::Memory;
use super::names::State;
use super::paths;
use super::scene::View;
use super::setup::BinStackSetup;
use super::supply;
use super::turn::Turn;
use robocell_skills::Reached;
use robocell_skills::matrix::MatrixRun;
use robocell_skills::pose;
use robocell_skills::setup::ARM;
use robocell_skills::suction::GripChange;
use robocell_task::job::Job;
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::policy::AnyPolicy;

/// An arm nearer than this to its target is on its way, whatever happened (m).
const ON_THE_WAY_M: f64 = 0.25;

/// What a decision found out before it asks the matrix.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) grip: GripChange,
    pub(super) reached: Reached,
}

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct BinStack {
    setup: Arc<BinStackSetup>,
    run: MatrixRun,
    memory: Memory,
}

impl BinStack {
    pub(super) fn new(setup: BinStackSetup) -> Self {
        Self {
            run: MatrixRun::new(Arc::clone(&setup.table)),
            setup: Arc::new(setup),
            memory: Memory::new(),
        }
    }

    fn state(&self) -> State {
        self.run.state().unwrap_or(State::Standby)
    }

    /// Handles one event, and notes a new state.
    fn step(
        &mut self,
        scene: View<'_, '_>,
        observation: &Observation<'_>,
        job: &mut Job,
        out: &mut Output,
    ) {
        let now = observation.time();
        let state = self.state();
        let row = state.precision(self.memory.opening());
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
        let handled = self.run.handle(pending, &mut turn);
        if self.run.tell(handled, out) {
            self.memory.since = now;
            job.counters.phase_entry += 1;
        }
    }

    fn report(&self, scene: View<'_, '_>, job: &mut Job, out: &mut Output) {
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
            out.event(
                TraceEvent::Done,
                format_args!("[decide] -> all {} bins stacked", job.placed.len()),
            );
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
        scene: View<'_, '_>,
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
            turn.out.event(
                TraceEvent::Recover,
                format_args!("[resume] {name} is in the hand"),
            );
            turn.choose_way()
        } else {
            turn.job.held = None;
            turn.go_home()
        };
        if self.run.set(next) {
            job.counters.phase_entry += 1;
        }
    }

    /// Whether what is remembered can go on as it is: the arm is where it was
    /// sent, and the hand holds what it should.
    fn goes_on(&self, scene: &View<'_, '_>, observation: &Observation<'_>) -> bool {
        let now = observation.time();
        let near = self.memory.motion.is_near(&scene.tcp, ON_THE_WAY_M, now);
        let at_rest = || pose::distance(&paths::rest(&self.setup), &scene.tcp) <= ON_THE_WAY_M;
        if !near.unwrap_or_else(at_rest) {
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

impl AnyPolicy for BinStack {
    fn reset(&mut self) {
        self.run.reset();
        self.memory = Memory::new();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = View::read(&setup, observation) else {
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
        let (motion, gripper) = (&self.memory.motion, self.memory.gripper());
        let intent = motion.intent(gripper, observation.time());
        out.arm(ARM, intent);
        self.report(scene, job, out);
    }

    fn tend(&self, observation: &Observation<'_>, job: &mut Job) {
        if let Some(scene) = View::read(&self.setup, observation) {
            supply::run_belt(&scene, job);
        }
    }

    fn phase(&self) -> Text<32> {
        self.run.phase()
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        self.run.describe()
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.run.statuses(out);
    }

    fn save(&self) -> Vec<u8> {
        self.run.save(&self.memory)
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let objects = self.setup.names.len();
        let sound = |memory: &Memory| memory.is_sound(objects);
        self.memory = self.run.restore(bytes, sound)?;
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = View::read(&setup, observation) else {
            return;
        };
        // Whatever was in the way, the state has its time again.
        self.memory.since = observation.time();
        if !self.goes_on(&scene, observation) {
            self.begin_from(scene, observation, job, out);
        }
    }
}
