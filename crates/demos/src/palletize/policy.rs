//! The policy: the table decides what to do with a bin, substeps do it.

use std::sync::Arc;

use behavior::{Graph, NodeStatus};
use ipc_types::decision::{GoalKind, Outcome};
use ipc_types::{GripperGoal, Text};
use serde::de::Error as _;
use serde_bytes::{ByteBuf, Bytes};

use super::aim;
use super::memory::{Memory, WorkKind};
use super::obstacles;
use super::setup::PalletizeSetup;
use super::steps::Step;
use super::table::{State, States};
use super::tick::Tick;
use robocell_skills::path::padded;
use robocell_skills::setup::ARM;
use robocell_task::checkpoint;
use robocell_task::job::Job;
use robocell_task::observation::Observation;
use robocell_task::output::{ArmIntent, Output};
use robocell_task::policy::AnyPolicy;
use robocell_task::time::PolicyTime;

/// See the module.
pub(super) struct Palletizer {
    pub(super) setup: Arc<PalletizeSetup>,
    pub(super) states: States,
    pub(super) memory: Memory,
}

impl Palletizer {
    /// A machine in its first state.
    pub(super) fn new(setup: Arc<PalletizeSetup>) -> Self {
        Self {
            states: States::new(Arc::clone(&setup.table)),
            memory: Memory::default(),
            setup,
        }
    }

    /// The goal of the arm.
    fn intent(&mut self, tick: &Tick<'_>, job: &Job) -> ArmIntent {
        let step = self
            .memory
            .work
            .and_then(|work| work.kind.sequence().step(work.step));
        let wanted = match (&self.memory.work, step) {
            (Some(work), Some(step)) => aim::motion(tick.setup, &tick.scene, work, step),
            _ => Some(aim::home_by_joints(tick.setup)),
        };
        self.memory.motion = wanted.or(self.memory.motion);
        let gripper = match &self.memory.work {
            Some(work) => work.kind.sequence().gripper(work.step),
            // What is not ours to carry is let go.
            None => GripperGoal::Open,
        };
        let held = ArmIntent {
            gripper,
            key: u64::from(job.counters.phase_entry),
            ..ArmIntent::default()
        };
        let Some(motion) = self.memory.motion else {
            return held;
        };
        let target = motion.target.isometry().translation.vector;
        let tool = tick.scene.tool.translation.vector;
        ArmIntent {
            kind: if motion.by_joints {
                GoalKind::Joints
            } else {
                GoalKind::Pose
            },
            target: motion.target.into(),
            posture: Some(padded(&motion.posture)),
            approach: motion.approach,
            approach_std_dev: motion.std_dev,
            obstacle_mask: obstacles::mask(tick.setup, self.memory.work.as_ref(), &tool, &target),
            ..held
        }
    }

    /// Whether the belt may run.
    fn belt_runs(&self, tick: &Tick<'_>) -> bool {
        let stops = self.memory.work.is_some_and(|work| {
            let waited = PolicyTime::from_seconds(tick.setup.numbers.pick.wait_s);
            let picks = matches!(work.kind, WorkKind::Pick | WorkKind::PickFlipped);
            picks && work.from_belt && (work.step > 0 || tick.now.since(work.began) >= waited)
        });
        !stops && !tick.bin_waits() && self.states.state() != State::Done
    }

    /// Asks for the next bin.
    fn supply(&mut self, tick: &Tick<'_>, job: &mut Job) {
        let now = tick.now;
        let interval = PolicyTime::from_seconds(tick.setup.numbers.supply_interval_s);
        let rested = self
            .memory
            .asked
            .map_or(now > PolicyTime::default(), |asked| {
                // What a task says first is where its counters stand.
                now.since(asked) >= interval
            });
        if rested && self.states.state() != State::Done && tick.wants_bin() {
            self.memory.asked = Some(now);
            job.io.add_bin += 1;
        }
    }

    fn report(&self, tick: &Tick<'_>, job: &mut Job, out: &mut Output) {
        out.phase = self.phase();
        out.outcome = match self.states.state() {
            State::Done => Outcome::Done,
            _ => Outcome::Running,
        };
        job.done = self.states.state() == State::Done;
        job.held = tick
            .scene
            .attached
            .and_then(|bin| Some(tick.setup.bins.get(bin)?.object));
        job.placed.clear();
        for (bin, _) in tick.scene.placed() {
            let object = tick.setup.bins.get(bin).map(|spec| spec.object);
            let number = object.and_then(|object| u32::try_from(object).ok());
            job.placed.extend(number);
        }
    }
}

impl AnyPolicy for Palletizer {
    fn reset(&mut self) {
        self.states.reset(Arc::clone(&self.setup.table));
        self.memory = Memory::default();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(tick) = Tick::new(&setup, observation) else {
            return;
        };
        self.advance(&tick, job, out);
        let intent = self.intent(&tick, job);
        out.arm(ARM, intent);
        job.io.conveyor_running = self.belt_runs(&tick);
        self.supply(&tick, job);
        self.report(&tick, job, out);
    }

    fn tend(&self, observation: &Observation<'_>, job: &mut Job) {
        if let Some(tick) = Tick::new(&self.setup, observation) {
            job.io.conveyor_running = self.belt_runs(&tick);
        }
    }

    fn phase(&self) -> Text<32> {
        let step = self
            .memory
            .work
            .and_then(|work| work.kind.sequence().step(work.step));
        Text::new(match step {
            Some(step) => step.name(),
            None if self.states.state() == State::Done => "done",
            None => "idle",
        })
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        vec![self.states.describe()]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.states.statuses(out);
    }

    fn save(&self) -> Vec<u8> {
        checkpoint::to_bytes(&(Bytes::new(&self.states.save()), &self.memory))
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let (states, memory): (ByteBuf, Memory) = checkpoint::from_bytes(bytes)?;
        if !memory.is_sound(&self.setup) {
            return Err(bincode::Error::custom("no job of this cell remembers that"));
        }
        if !self.states.restore(&states) {
            return Err(bincode::Error::custom("its state is not in the table"));
        }
        self.memory = memory;
        Ok(())
    }

    /// What is on the cup decides: a bin that the checkpoint does not know about is
    /// carried on with, one that it believes there and is not was lost, which
    /// the next tick says.
    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(tick) = Tick::new(&setup, observation) else {
            return;
        };
        let Some(bin) = tick.scene.attached else {
            return;
        };
        let expected = self.memory.work.is_some_and(|work| {
            let sequence = work.kind.sequence();
            let touches = matches!(
                sequence.step(work.step),
                Some(Step::CloseSuctionGripper | Step::OpenSuctionGripper)
            );
            // One that took too long was given up: its way begins anew.
            let timeout = PolicyTime::from_seconds(setup.numbers.reach_timeout_s);
            let late = tick.now.since(work.began) >= timeout;
            work.bin == bin && (sequence.holds(work.step) || touches) && !late
        });
        if !expected && self.states.state() != State::Done {
            self.adopt(bin, &tick, job, out);
        }
    }
}
