//! The policy: the table chooses the work on a bin, and its steps carry it out.

use std::sync::Arc;

use behavior::{Graph, NodeStatus};
use ipc_types::decision::Outcome;
use ipc_types::{GripperGoal, Text};
use robocell_skills::setup::ARM;
use robocell_skills::{KeptPose, MachineRun, Named as _, pose};
use robocell_task::{AnyPolicy, ArmIntent, Job, Observation, Output, PolicyTime, checkpoint};
use serde::de::Error as _;
use serde_bytes::{ByteBuf, Bytes};

use super::memory::{Memory, Work};
use super::motion;
use super::obstacles;
use super::scene::View;
use super::setup::PalletizeSetup;
use super::steps::Step;
use super::table::State;

/// See the module.
pub(super) struct Palletizer {
    pub(super) setup: Arc<PalletizeSetup>,
    pub(super) run: MachineRun,
    pub(super) memory: Memory,
}

impl Palletizer {
    /// A policy whose machine is in its first state.
    pub(super) fn new(setup: Arc<PalletizeSetup>) -> Self {
        Self {
            run: MachineRun::new(Arc::clone(&setup.table)),
            memory: Memory::default(),
            setup,
        }
    }

    /// The state; an additional state of the file counts as idle.
    pub(super) fn state(&self) -> State {
        let mut known = State::ALL.iter();
        let state = known.find(|state| state.name() == self.run.state());
        state.copied().unwrap_or(State::Idle)
    }

    fn step(&self) -> Option<(&Work, &Step)> {
        let work = self.memory.work.as_ref()?;
        Some((work, self.setup.sequence(work.kind).step(work.step)?))
    }

    /// The goal of the arm.
    fn intent(&mut self, view: &View<'_>, job: &Job) -> ArmIntent {
        let wanted = match self.step() {
            // Without a place the arm stays where it is.
            Some((work, _)) if work.waits() => None,
            Some((work, step)) => {
                let go = step.table.go.as_ref();
                go.and_then(|go| motion::waypoint(view, work, go))
            }
            None => Some(motion::home_by_joints(view.setup)),
        };
        let path = &mut self.memory.path;
        match wanted {
            // An arm under way only gets a new aim: a new path would start at the tool again.
            Some(waypoint) if path.is_moving() => path.aim(waypoint),
            Some(waypoint) => path.go(waypoint, &pose::wire(&view.tool), view.now),
            None => {}
        }
        let work = self.memory.work.as_ref();
        // Without work the cup is open; with it the sequence decides, also in steps without
        // suction.
        let gripper = work.map_or(GripperGoal::Open, |work| {
            view.setup.sequence(work.kind).gripper(work.step)
        });
        let intent = self.memory.path.intent(gripper, view.now);
        let target = KeptPose::from(intent.target).isometry().translation.vector;
        let tool = view.tool.translation.vector;
        ArmIntent {
            key: job.newest_key,
            obstacle_mask: obstacles::mask(view.setup, work, &tool, &target),
            ..intent
        }
    }

    /// Whether the belt runs.
    fn belt_runs(&self, view: &View<'_>) -> bool {
        let stops = self.step().is_some_and(|(work, step)| {
            let wait = step.table.wait_s.filter(|_| step.table.stops_belt);
            let waits = wait
                .is_some_and(|wait| view.now.since(work.began) < PolicyTime::from_seconds(wait));
            // The belt stops at the end of the waiting step and stays stopped while the bin is
            // picked.
            work.kind.picks() && work.from_belt && !waits
        });
        !stops && !view.bin_waits() && self.state() != State::Done
    }

    /// Requests the next bin.
    fn supply(&mut self, view: &View<'_>, job: &mut Job) {
        let interval = PolicyTime::from_seconds(view.setup.task.supply_interval_s);
        // Physics ignores the first counter of a task, which may have counted before: the first
        // decision only makes the counter known.
        let may_ask = match self.memory.asked {
            Some(asked) => view.now.since(asked) >= interval,
            None => view.now > PolicyTime::default(),
        };
        if may_ask && self.state() != State::Done && view.wants_bin() {
            self.memory.asked = Some(view.now);
            job.io.add_bin += 1;
        }
    }

    fn report(&self, view: &View<'_>, job: &mut Job, out: &mut Output) {
        out.phase = self.phase();
        job.done = self.state() == State::Done;
        out.outcome = if job.done {
            Outcome::Done
        } else {
            Outcome::Running
        };
        let object = |bin: usize| view.setup.bins.get(bin).map(|bin| bin.object);
        job.held = view.attached.and_then(object);
        let placed = view.placed().filter_map(|(bin, _)| object(bin));
        // Rebuilt in each decision from the observation, so a bin that was moved is not listed
        // any longer.
        job.placed.clear();
        job.placed
            .extend(placed.filter_map(|object| u32::try_from(object).ok()));
    }
}

impl AnyPolicy for Palletizer {
    fn reset(&mut self) {
        self.run.reset();
        self.memory = Memory::default();
    }

    fn decide(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(view) = View::read(&setup, observation) else {
            return;
        };
        self.advance(&view, job, out);
        let intent = self.intent(&view, job);
        out.arm(ARM, intent);
        job.io.conveyor_running = self.belt_runs(&view);
        self.supply(&view, job);
        self.report(&view, job, out);
    }

    fn tend(&self, observation: &Observation<'_>, job: &mut Job) {
        if let Some(view) = View::read(&self.setup, observation) {
            job.io.conveyor_running = self.belt_runs(&view);
        }
    }

    fn phase(&self) -> Text<32> {
        Text::new(match self.step() {
            Some((_, step)) => &step.phase,
            None if self.state() == State::Done => "done",
            None => "idle",
        })
    }

    fn describe(&self, _name: &str) -> Vec<Graph> {
        vec![self.run.describe()]
    }

    fn statuses(&self, _graph: usize, out: &mut Vec<NodeStatus>) {
        self.run.statuses(out);
    }

    fn save(&self) -> Vec<u8> {
        checkpoint::to_bytes(&(Bytes::new(&self.run.save()), &self.memory))
    }

    fn restore(&mut self, bytes: &[u8]) -> Result<(), bincode::Error> {
        let (state, memory): (ByteBuf, Memory) = checkpoint::from_bytes(bytes)?;
        // A checkpoint is checked as a whole before anything is restored: half of one would mix
        // two jobs.
        if !memory.is_sound(&self.setup) {
            return Err(bincode::Error::custom("not a checkpoint of this cell"));
        }
        self.run.restore(&state)?;
        self.memory = memory;
        Ok(())
    }

    /// The bin on the cup decides: one that the checkpoint does not have is carried to its
    /// place. A bin of the checkpoint that is not on the cup was lost, which the next decision
    /// notices.
    fn reconcile(&mut self, observation: &Observation<'_>, job: &mut Job, out: &mut Output) {
        let setup = Arc::clone(&self.setup);
        let Some(view) = View::read(&setup, observation) else {
            return;
        };
        let Some(bin) = view.attached else {
            return;
        };
        let expected = self.step().is_some_and(|(work, step)| {
            let holds = setup.sequence(work.kind).holds(work.step);
            // A motion that took too long was given up, whatever was on the cup.
            let timeout = PolicyTime::from_seconds(setup.task.reach_timeout_s);
            let late = view.now.since(work.began) >= timeout;
            work.bin == bin && (holds || step.table.suction.is_some()) && !late
        });
        if !expected && self.state() != State::Done {
            self.adopt(bin, &view, job, out);
        }
    }
}
