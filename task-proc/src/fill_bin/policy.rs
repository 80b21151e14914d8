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
use super::scene::{ARM, Scene};
use super::setup::FillBinSetup;
use super::turn::Turn;
use crate::job::Job;
use crate::observation::Observation;
use crate::output::Output;
use crate::policy::Policy;
use crate::record;
use crate::time::PolicyTime;
use crate::ur10::Reached;

/// An arm nearer than this to its target is on its way, whatever happened (m).
const ON_THE_WAY_M: f64 = 0.25;

/// See the module.
#[derive(Clone, Debug)]
pub(super) struct FillBin {
    setup: Arc<FillBinSetup>,
    matrix: Matrix,
    memory: Memory,
}

#[derive(Serialize, Deserialize)]
struct Record {
    #[serde(with = "serde_bytes")]
    matrix: Vec<u8>,
    memory: Memory,
}

impl FillBin {
    pub(super) fn new(setup: FillBinSetup) -> Self {
        Self {
            matrix: Matrix::new(Arc::clone(&setup.table)),
            setup: Arc::new(setup),
            memory: Memory::new(),
        }
    }

    fn state(&self) -> State {
        State::of(self.matrix.state())
    }

    /// Handles one event.
    fn step(&mut self, scene: Scene<'_, '_>, now: PolicyTime, job: &mut Job, out: &mut Output) {
        let state = self.state();
        let found = Found {
            grip: self.memory.grip.update(scene.gripper),
            reached: if now < self.memory.wait_until {
                Reached::Nothing
            } else {
                self.memory.motion.step(&scene.tcp, state.row(), now)
            },
        };
        // Kept until it is handled; what is gone again is no news.
        self.memory.attached |= found.grip.attached;
        self.memory.attached &= scene.gripper.attached == 1;
        let pending = events::pending(state, &scene, &self.memory, job, found, now);
        let mut turn = Turn {
            scene,
            memory: &mut self.memory,
            job,
            out,
            now,
            broken: found.grip.broken,
        };
        self.matrix.clear_trace();
        if let Err(wrong) = self.matrix.tick(pending, &mut turn) {
            out.log(format_args!("[error] {wrong}"));
        }
        self.note_changes(now, job, out);
    }

    /// Says which events were handled, and which state was left for which.
    fn note_changes(&mut self, now: PolicyTime, job: &mut Job, out: &mut Output) {
        let table = self.matrix.table();
        let idle = table.event("NONE");
        for happening in self.matrix.trace() {
            match *happening {
                Happening::Changed { from, to, event } => {
                    let event = table.event_name(event);
                    let (at, to_at) = ((0, from.index()), (0, to.index()));
                    out.status(at, NodeStatus::Running, NodeStatus::Invalid, event);
                    out.status(to_at, NodeStatus::Invalid, NodeStatus::Running, event);
                    let (from, to) = (table.state_name(from), table.state_name(to));
                    out.transition(format_args!("{from} -> {to} ({event})"));
                    self.memory.since = now;
                    job.counters.phase_entry += 1;
                }
                Happening::Handled {
                    state,
                    event,
                    handler: Some(_),
                } if Some(event) != idle => {
                    // A cell at work again and again is worth one line.
                    let shown = Some((state.0, event.0));
                    if std::mem::replace(&mut self.memory.shown, shown) != shown {
                        out.guard((0, state.index()), table.event_name(event), true);
                    }
                }
                _ => {}
            }
        }
    }

    fn report(&self, scene: &Scene<'_, '_>, job: &mut Job, out: &mut Output) {
        job.placed.clear();
        out.phase = self.phase();
        out.outcome = match (job.done, job.started || scene.holds_bin()) {
            (true, _) => Outcome::Done,
            (false, true) => Outcome::Running,
            (false, false) => Outcome::Idle,
        };
    }
}

impl Policy for FillBin {
    fn name(&self) -> &'static str {
        NAME
    }

    fn reset(&mut self) {
        self.matrix = Matrix::new(Arc::clone(&self.setup.table));
        self.memory = Memory::new();
        self.memory.let_go = true;
    }

    fn tick(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = Scene::read(&setup, observation) else {
            return;
        };
        let now = observation.time();
        self.step(scene, now, job, out);
        let selector = u32::from(self.matrix.state().0);
        let intent = self
            .memory
            .motion
            .intent(self.memory.gripper(), selector, now);
        out.arm(ARM, intent);
        self.report(&scene, job, out);
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
        if !record.memory.motion.is_sound() {
            return Err(serde::de::Error::custom("a path of a record is too long"));
        }
        self.matrix
            .restore(&record.matrix)
            .map_err(<bincode::Error as serde::de::Error>::custom)?;
        self.memory = record.memory;
        Ok(())
    }

    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(scene) = Scene::read(&setup, observation) else {
            return;
        };
        let now = observation.time();
        let target = self.memory.motion.target(now);
        let near = target.is_some_and(|target| distance(&target, &scene.tcp) < ON_THE_WAY_M);
        let attached = scene.gripper.attached == 1;
        let let_go = std::mem::take(&mut self.memory.let_go);
        if !let_go && (near || attached != self.memory.grip.attached()) {
            // The next decision sees by itself what changed.
            return;
        }
        if attached && !let_go {
            self.memory.attached = true;
            self.memory.motion.stop();
            out.log(format_args!("[resume] {} is in the hand", setup.task.bin));
            job.counters.recoveries += 1;
            return;
        }
        // What is let go is no news.
        self.memory.grip.update(scene.gripper);
        self.memory.since = now;
        job.held = None;
        job.done = false;
        self.matrix.set_state(State::Standby.id());
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

fn distance(a: &ipc_types::Pose, b: &ipc_types::Pose) -> f64 {
    let offset = nalgebra::Vector3::from(a.position) - nalgebra::Vector3::from(b.position);
    offset.norm()
}
