//! The matrix at work.

use robocell_task::TraceEvent;
use std::sync::Arc;

use behavior::{Graph, NodeStatus};
use ipc_types::Text;
use ipc_types::decision::Outcome;

use super::events;
use super::memory::Memory;
use super::names::State;
use super::scene::View;
use super::setup::FillBinSetup;
use super::turn::Turn;
use robocell_skills::Reached;
use robocell_skills::matrix::{self, MatrixRun};
use robocell_skills::setup::ARM;
use robocell_skills::suction::GripChange;
use robocell_task::job::Job;
use robocell_task::observation::Observation;
use robocell_task::output::Output;
use robocell_task::policy::AnyPolicy;
use robocell_task::time::PolicyTime;

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
pub(super) struct FillBin {
    setup: Arc<FillBinSetup>,
    run: MatrixRun,
    memory: Memory,
}

impl FillBin {
    pub(super) fn new(setup: FillBinSetup) -> Self {
        Self {
            run: MatrixRun::new(Arc::clone(&setup.table)),
            setup: Arc::new(setup),
            memory: Memory::new(),
        }
    }

    fn state(&self) -> State {
        self.run.state().unwrap_or(State::Standby)
    }

    /// Handles one event.
    fn step(&mut self, scene: View<'_, '_>, now: PolicyTime, job: &mut Job, out: &mut Output) {
        let state = self.state();
        let found = Found {
            grip: self.memory.grip.update(scene.gripper),
            reached: if now < self.memory.wait_until {
                Reached::Nothing
            } else {
                self.memory.motion.step(&scene.tcp, state.precision(), now)
            },
        };
        // Kept until it is handled; what is gone again is no news.
        self.memory.attached |= found.grip.attached;
        self.memory.attached &= scene.gripper.attached == 1;
        if found.grip.attached {
            // The operator's grip is no longer the operator's after a pause: it
            // stays until ATTACHED says what hangs on it.
            self.memory.switch(true);
        }
        let pending = events::pending(state, &scene, &self.memory, job, found, now);
        let mut turn = Turn {
            scene,
            memory: &mut self.memory,
            job,
            out,
            now,
            broken: found.grip.broken,
        };
        let handled = self.run.handle(pending, &mut turn);
        if self.run.tell(handled, out) {
            self.memory.since = now;
            job.counters.phase_entry += 1;
        }
    }

    fn report(&self, scene: &View<'_, '_>, job: &mut Job, out: &mut Output) {
        job.placed.clear();
        out.phase = self.phase();
        out.outcome = match (job.done, job.started || scene.holds_bin()) {
            (true, _) => Outcome::Done,
            (false, true) => Outcome::Running,
            (false, false) => Outcome::Idle,
        };
    }
}

impl AnyPolicy for FillBin {
    fn reset(&mut self) {
        self.run.reset();
        self.memory = Memory::new();
        self.memory.let_go = true;
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = View::read(&setup, observation) else {
            return;
        };
        let now = observation.time();
        self.step(scene, now, job, out);
        let (motion, gripper) = (&self.memory.motion, self.memory.gripper());
        out.arm(ARM, motion.intent(gripper, now));
        self.report(&scene, job, out);
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
        let sound = |memory: &Memory| memory.motion.is_sound();
        self.memory = self.run.restore(bytes, sound)?;
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = View::read(&setup, observation) else {
            return;
        };
        let now = observation.time();
        let near = self.memory.motion.is_near(&scene.tcp, ON_THE_WAY_M, now);
        let near = near.unwrap_or(false);
        let attached = scene.gripper.attached == 1;
        let let_go = std::mem::take(&mut self.memory.let_go);
        if !let_go && (near || attached != self.memory.grip.attached()) {
            // The next decision sees by itself what changed.
            return;
        }
        if attached && !let_go {
            self.memory.attached = true;
            self.memory.motion.stop();
            out.event(
                TraceEvent::Recover,
                format_args!("[resume] {} is in the hand", setup.task.bin),
            );
            job.counters.recoveries += 1;
            return;
        }
        // What is let go is no news.
        self.memory.grip.update(scene.gripper);
        self.memory.since = now;
        job.held = None;
        job.done = false;
        self.run.set(matrix::goto(State::Standby));
        let mut turn = Turn {
            scene,
            memory: &mut self.memory,
            job,
            out,
            now,
            broken: false,
        };
        turn.back_to_rest();
    }
}
