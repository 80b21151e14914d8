//! A cell in one process whose members talk in stamped messages, late and with
//! gaps where a test wants it, as the processes of a cell do; and a recorder.

#![allow(
    dead_code,
    clippy::expect_used,
    clippy::cast_possible_truncation,
    reason = "a test fails by panicking; each test uses its own part; arms are few"
)]

use cell_model::Cell;
use cell_run::spec::RunSpec;
use cell_sim::eval;
use cell_sim::verify::Message;
use controller_proc::cycle::Cycle;
use controller_proc::planning::Planner;
use ipc_types::header::Message as _;
use ipc_types::tap::Pieces;
use ipc_types::topic::Process;
use ipc_types::{
    ArmCommand, ArmStatus, Decision, Header, Keyframe, MAX_ARMS, Wire, WorldPiece, WorldState,
};
use physics_proc::plant::{Next, Plant};
use physics_proc::world::StepInput;
use robocell_task::Task;
use robocell_task::inputs::{MISSED_TICKS, name_inputs};

const RUN: u64 = 77;
const LIMIT: u64 = 80;
/// Ticks from the request for a plan to its answer.
const PLANNED_TICKS: u64 = 73;

/// Deviations from lockstep.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Timing {
    /// A controller misses this state.
    pub(crate) misses: Option<fn(arm: usize, tick: u64) -> bool>,
    /// Ticks until a decision is received.
    pub(crate) late: Option<fn(tick: u64) -> u64>,
    /// The task sees no state at this tick.
    pub(crate) dozes: Option<fn(tick: u64) -> bool>,
}

struct Arm {
    cycle: Cycle,
    planner: Planner,
    generation: u32,
    seq: u64,
    command: Option<ArmCommand>,
    statuses: Vec<ArmStatus>,
}

struct Policy {
    task: Task,
    generation: u32,
    seq: u64,
    decided: Option<(u32, u64)>,
    message: Decision,
    sent: Vec<(u64, Decision)>,
}

/// The cell and what was recorded of it.
pub(crate) struct Bench {
    pub(crate) spec: RunSpec,
    pub(crate) cell: Cell,
    timing: Timing,
    plant: Plant,
    state: Box<WorldState>,
    states: u64,
    tap: u64,
    arms: Vec<Arm>,
    policy: Policy,
    topics: Vec<Vec<Message>>,
    /// In the order of a recorder that empties one topic after the other.
    pub(crate) recorded: Vec<Message>,
}

impl Bench {
    pub(crate) fn new(demo: &str, policy: &str, script: &str, timing: Timing) -> Self {
        let mut spec = eval::template(demo, policy);
        spec.seed = 3;
        spec.script = cell_model::cells::script::parse(script, "script").expect("a script");
        let cell = spec
            .load_cell_from(&cell_model::Data::checkout())
            .expect("a cell");
        let plant = Plant::new(&cell, &spec).expect("a plant");
        let arms = (0..cell.arms.len()).map(|arm| Arm {
            cycle: Cycle::new(&cell, arm).expect("a controller"),
            planner: Planner::new(&cell, arm).expect("a planner"),
            generation: 1,
            seq: 0,
            command: None,
            statuses: Vec::new(),
        });
        let mut bench = Self {
            arms: arms.collect(),
            policy: Policy {
                task: demos::policies().task(&cell, policy).expect("a task"),
                generation: 1,
                seq: 0,
                decided: None,
                message: Decision::zeroed(),
                sent: Vec::new(),
            },
            spec,
            cell,
            timing,
            plant,
            state: Box::new(WorldState::zeroed()),
            states: 0,
            tap: 0,
            topics: vec![Vec::new(); 8],
            recorded: Vec::new(),
        };
        for arm in 0..bench.arms.len() {
            bench.keep_arm(arm, &Header::zeroed());
        }
        bench.keep_task();
        bench
    }

    pub(crate) fn run(&mut self, ticks: u64) {
        for _ in 0..ticks {
            self.tick();
        }
        self.drain();
    }

    /// The last message of arm `index`.
    pub(crate) fn status(&self, index: usize) -> &ArmStatus {
        self.arms[index].statuses.last().expect("it said something")
    }

    /// Another process in the place of a controller.
    pub(crate) fn restart_controller(&mut self, index: usize) {
        let cycle = Cycle::new(&self.cell, index).expect("a controller");
        let arm = &mut self.arms[index];
        (arm.cycle, arm.seq) = (cycle, 0);
        arm.generation += 1;
        self.keep_arm(index, &Header::zeroed());
    }

    /// Another process in the place of the task, `away` ticks later.
    pub(crate) fn restart_task(&mut self, policy: &str, away: u64) {
        let record = self.policy.task.checkpoint();
        let asleep = self.timing.dozes.replace(|_| true);
        self.run(away);
        self.timing.dozes = asleep;
        let task = &mut self.policy;
        task.task = demos::policies().task(&self.cell, policy).expect("a task");
        task.task.restore(&record).expect("its record");
        if away > 10 {
            task.task.reconcile(&self.state);
        }
        task.generation += 1;
        task.seq = 0;
        self.publish_decision();
        self.keep_task();
    }

    fn tick(&mut self) {
        self.plant.write_state(&mut self.state);
        self.states += 1;
        stamp(&mut *self.state, 1, self.states);
        self.tap_state();
        let tick = self.state.header.tick;
        let dozes = self.timing.dozes.is_some_and(|dozes| dozes(tick));
        let due = self
            .policy
            .decided
            .is_none_or(|(_, last)| tick / 10 > last / 10);
        if due && !dozes {
            self.decide();
        }
        for arm in 0..self.arms.len() {
            if !self.timing.misses.is_some_and(|misses| misses(arm, tick)) {
                self.control(arm);
            }
        }
        self.step();
        if tick.is_multiple_of(64) {
            self.drain();
        }
    }

    fn step(&mut self) {
        let decision = self.policy.sent.last().map(|(_, decision)| *decision);
        if self.plant.before_step(decision.as_ref()) == Next::Wait {
            return;
        }
        let mut commands = [None; MAX_ARMS];
        for (slot, arm) in commands.iter_mut().zip(&self.arms) {
            *slot = arm.command.as_ref();
        }
        self.plant.step(&StepInput {
            commands,
            decision: decision.as_ref(),
        });
    }

    fn decide(&mut self) {
        let (state, policy) = (&*self.state, &mut self.policy);
        let tick = state.header.tick;
        if policy
            .decided
            .is_some_and(|(_, last)| tick > last + MISSED_TICKS)
        {
            policy.task.reconcile(state);
        }
        let mut statuses = [None; MAX_ARMS];
        for (slot, arm) in statuses.iter_mut().zip(&self.arms) {
            *slot = arm.statuses.iter().rfind(|s| s.header.tick < tick);
        }
        let message = &mut policy.message;
        policy
            .task
            .decide(state, &statuses, message, &mut Vec::new());
        name_inputs(&mut message.header, state, &statuses);
        let second = policy.decided.map(|(_, last)| last / 1000);
        policy.decided = Some((1, tick));
        self.publish_decision();
        if second != Some(tick / 1000) || !tick.is_multiple_of(10) {
            self.keep_task();
        }
    }

    fn publish_decision(&mut self) {
        let policy = &mut self.policy;
        policy.seq += 1;
        let mut message = policy.message;
        stamp(&mut message, policy.generation, policy.seq);
        let now = self.state.header.tick;
        let heard = now + self.timing.late.map_or(0, |late| late(now));
        policy.sent.push((heard, message));
        self.topics[0].push(Message::Decision(Box::new(message)));
    }

    fn control(&mut self, index: usize) {
        let tick = self.state.header.tick;
        let heard = self.policy.sent.iter().rev();
        let decision = heard
            .filter(|(heard, decision)| *heard <= tick && decision.header.tick < tick)
            .map(|(_, decision)| decision)
            .next();
        let arm = &mut self.arms[index];
        // Later than in lockstep, as on a busy machine.
        if let Some(request) = arm.cycle.plan_request()
            && tick >= request.tick + PLANNED_TICKS
        {
            let answer = arm.planner.answer(&request);
            arm.cycle.answer_plan(&mut Some(answer));
        }
        let (mut command, mut status) = (ArmCommand::zeroed(), ArmStatus::zeroed());
        arm.cycle
            .update(&self.state, decision, LIMIT, &mut command, &mut status);
        arm.seq += 1;
        stamp(&mut status, arm.generation, arm.seq);
        stamp(&mut command, arm.generation, arm.seq);
        arm.command = Some(command);
        arm.statuses.push(status);
        let keep = arm.seq == 1 || tick.is_multiple_of(1000);
        let name = index as u8;
        self.topics[1 + index].push(Message::Command(name, Box::new(command)));
        self.topics[3 + index].push(Message::Status(name, Box::new(status)));
        if keep {
            self.keep_arm(index, &command.header);
        }
    }

    fn keep_arm(&mut self, index: usize, of_command: &Header) {
        let arm = &mut self.arms[index];
        let mut keyframe = Box::new(Keyframe::zeroed());
        keyframe.header = *of_command;
        stamp(&mut *keyframe, arm.generation, arm.seq + 1);
        keyframe.after_seq = arm.seq;
        let length = arm.cycle.save(LIMIT, &mut keyframe.bytes).expect("room");
        keyframe.len = length as u32;
        keyframe.total = length as u64;
        let process = Process::Controller(index as u8);
        self.topics[5].push(Message::Keyframe(process, keyframe));
    }

    fn keep_task(&mut self) {
        let policy = &self.policy;
        let mut keyframe = Box::new(Keyframe::zeroed());
        keyframe.header = policy.message.header;
        stamp(&mut *keyframe, policy.generation, policy.seq + 1);
        keyframe.after_seq = policy.seq;
        let checkpoint = policy.task.checkpoint();
        let mut offset = 0;
        loop {
            keyframe.set(&checkpoint, offset);
            offset += keyframe.bytes().len();
            self.topics[6].push(Message::Keyframe(Process::Task, keyframe.clone()));
            if keyframe.is_last() {
                break;
            }
        }
    }

    fn tap_state(&mut self) {
        let (mut pieces, mut piece) = (Pieces::of(&self.state, &[]), WorldPiece::zeroed());
        while pieces.write_next(&self.state, &mut piece) {
            self.tap += 1;
            stamp(&mut piece, 1, self.tap);
            self.topics[7].push(Message::World(Box::new(piece)));
        }
    }

    fn drain(&mut self) {
        for topic in &mut self.topics {
            self.recorded.append(topic);
        }
    }
}

fn stamp<T: ipc_types::header::Message>(message: &mut T, generation: u32, seq: u64) {
    let header = message.header_mut();
    header.schema = T::SCHEMA;
    (header.run, header.generation, header.seq) = (RUN, generation, seq);
    header.publish_ns = 1_000_000_007 * seq;
}

/// Tick that caused a message.
pub(crate) fn tick_of(message: &Message) -> u64 {
    match message {
        Message::World(piece) => piece.state.tick,
        Message::Command(_, command) => command.header().tick,
        Message::Status(_, status) => status.header().tick,
        Message::Decision(decision) => decision.header().tick,
        Message::Client(_, input) => input.header.tick,
        Message::Keyframe(_, keyframe) => keyframe.header().tick,
    }
}
