//! A task with a policy in plain code, in a cell whose state the test writes.

use std::sync::LazyLock;

use cell_model::{Cell, Data};
use ipc_types::decision::Outcome;
use ipc_types::{
    ArmStatus, DECISION_TICKS, Decision, GripperGoal, Header, Pose, Validate as _, Wire as _,
    WorldState,
};
use robocell_task::{
    ArmIntent, Job, Observation, Output, Policy, Task, TraceEvent, TraceLineText, boxed,
};
use serde::{Deserialize, Serialize};

/// Force with which the operator closes the gripper (N).
pub(crate) const GRIP_FORCE_N: f64 = 12.5;

/// Failed attempts that end a job.
pub(crate) const ATTEMPTS: u32 = 3;

pub(crate) const UP: Pose = Pose {
    position: [0.4, 0.1, 0.5],
    orientation_wxyz: [0.0, 0.8, 0.6, 0.0],
};

/// The decisions of [`Worker`], written by the test.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Plan {
    /// From this decision on each one is a failed attempt, 0 for never.
    pub(crate) fails: u32,
    /// In this decision a fault is reported that is not the reason of the failure.
    pub(crate) faults: u32,
    /// In this decision the target is not a number.
    pub(crate) not_a_number: u32,
}

/// Ten decisions per phase; it moves every arm and requests a bin in each phase.
pub(crate) struct Worker(pub(crate) Plan);

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Memory {
    pub(crate) decisions: u32,
    pub(crate) reconciled: u32,
}

const PHASES: [&str; 3] = ["FETCH", "BRING", "PUT"];

impl Policy for Worker {
    type Memory = Memory;

    fn decide(&self, memory: &mut Memory, _: &Observation<'_>, job: &mut Job, out: &mut Output) {
        memory.decisions += 1;
        let Plan {
            fails,
            faults,
            not_a_number,
        } = self.0;
        if memory.decisions % 10 == 1 {
            job.io.add_bin += 1;
        }
        job.io.conveyor_running = true;
        let mut target = UP;
        if memory.decisions == not_a_number {
            target.position[2] = f64::NAN;
        }
        for arm in 0..2 {
            let intent = ArmIntent {
                gripper: GripperGoal::Close,
                ..ArmIntent::pose(u64::from(memory.decisions / 10) + 1, target)
            };
            out.arm(arm, intent);
        }
        out.log(format_args!("decision {}", memory.decisions));
        if memory.decisions == faults {
            let line = format_args!("[fault] a sensor is dirty");
            out.event(TraceEvent::Fault, line);
        }
        if fails > 0 && memory.decisions >= fails {
            let attempts = job.attempts_mut(0, 0).unwrap();
            attempts.pick += 1;
            if attempts.pick >= ATTEMPTS {
                job.fail("no_more_cubes");
            }
        }
    }

    fn is_sound(&self, memory: &Memory) -> bool {
        memory.decisions < 1000
    }

    fn phase(&self, memory: &Memory) -> &str {
        let phase = memory.decisions as usize / 10 % PHASES.len();
        PHASES[phase]
    }

    fn phases(&self) -> &[&str] {
        &PHASES
    }

    fn reconcile(&self, memory: &mut Memory, _: &Observation<'_>, _: &mut Job, _: &mut Output) {
        memory.reconciled += 1;
    }

    fn tend(&self, _: &Observation<'_>, job: &mut Job) {
        job.io.conveyor_running = false;
    }
}

pub(crate) fn load(demo: &str) -> Cell {
    Cell::load(&Data::checkout(), demo, 1, None).unwrap()
}

/// Loaded once: a test that restores a task a hundred times makes it as often.
static PYRAMID: LazyLock<Cell> = LazyLock::new(|| load("franka-pyramid"));

/// A task of two arms and six cubes.
pub(crate) fn worker(plan: Plan) -> Task {
    Task::new(&PYRAMID, "worker", GRIP_FORCE_N, boxed(Worker(plan)))
}

/// A state of physics' first start.
pub(crate) fn state(tick: u64) -> Box<WorldState> {
    let mut state = Box::new(WorldState::zeroed());
    state.header = Header::caused_by::<WorldState>(tick);
    state.header.generation = 1;
    (state.arm_count, state.object_count) = (2, 6);
    for arm in &mut state.arms {
        arm.tcp = UP;
    }
    state
}

pub(crate) struct Bench {
    pub(crate) task: Task,
    pub(crate) state: Box<WorldState>,
    pub(crate) decision: Box<Decision>,
    /// Those of the newest decision.
    pub(crate) lines: Vec<TraceLineText>,
}

impl Bench {
    pub(crate) fn new(plan: Plan) -> Self {
        Self::of(worker(plan))
    }

    pub(crate) fn of(task: Task) -> Self {
        Self {
            task,
            state: state(0),
            decision: Box::new(Decision::zeroed()),
            lines: Vec::new(),
        }
    }

    /// The next decision, a valid one.
    pub(crate) fn decide(&mut self) {
        let tick = self.state.header.tick + DECISION_TICKS;
        self.state.header.tick = tick;
        self.lines.clear();
        let status: [Option<&ArmStatus>; 2] = [None, None];
        self.task
            .decide(&self.state, &status, &mut self.decision, &mut self.lines);
        self.decision.validate().unwrap();
    }

    pub(crate) fn decide_times(&mut self, count: u32) {
        (0..count).for_each(|_| self.decide());
    }

    /// The lines of the newest decision with `part`.
    pub(crate) fn count(&self, part: &str) -> usize {
        let texts = self.lines.iter().map(|line| line.text.as_str());
        texts.filter(|text| text.contains(part)).count()
    }

    pub(crate) fn outcome(&self) -> Outcome {
        Outcome::from_code(self.decision.outcome).unwrap()
    }

    /// By arm: kind of goal, gripper.
    pub(crate) fn goals(&self) -> [(u32, u32); 2] {
        self.decision.goals.map(|goal| (goal.kind, goal.gripper))
    }
}

/// The memory of the worker in a checkpoint of its task.
pub(crate) fn memory(task: &Task) -> Memory {
    // The memory is the last field: its length, then its bytes.
    let bytes = task.checkpoint();
    let of_memory = bytes.get(bytes.len() - 8..).unwrap();
    robocell_task::checkpoint::from_bytes(of_memory).unwrap()
}
