//! The task on the bus: on every tenth tick it observes, decides, writes its checkpoint
//! and publishes.
//!
//! What can go wrong here, and the rule that prevents it:
//! - a kill between two steps: the checkpoint is written before the decision is published.
//!   In the other order a successor would not know a decision that the arm follows already,
//!   and would give its next goal the same number;
//! - a decision that was written but reached no reader: the successor publishes it again.
//!   It is absolute and carries its tick, so a repetition changes nothing (ADR 0002);
//! - in lockstep a decision on statuses that happen to have arrived: the statuses of the tick
//!   before are waited for, so that equal runs have equal inputs (ADR 0004). The wait is
//!   bounded, since a controller that was killed publishes nothing;
//! - a task that hangs while its process lives: the supervisor sees that `health` reports no
//!   cycle.
//!
//! A change must keep the order in `TaskProcess::decide` (statuses, `begin`, `decide`,
//! slots, `publish`) and must not block between them: physics in lockstep waits.

mod trace;

use cell_bus::{Bus, BusError, Doorbell, Publisher, Subscriber};
use cell_rt::{Clock, Monotonic, priority::TASK_PRIORITY};
use cell_worker::{
    DELIVERY_NS, Gated, HealthReporter, Keyframes, LoopClass, RunError, Start, Turn, Wait, Woken,
};
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_LOCKSTEP;
use ipc_types::{
    ArmStatus, DECISION_TICKS, Decision, Header, MAX_ARMS, TraceLine, Wire, WorldState,
};

use robocell_task::output::ROOM_FOR_LINES;
use robocell_task::starts::{Begun, Decider};
use robocell_task::{Policies, Task, TaskError, TraceLineText};

use crate::message_file::MessageFile;
use crate::slots::{ModelFiles, Slots, SlotsError};
use trace::Pictures;

/// Why a task cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The policy.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// The two-slot file.
    #[error(transparent)]
    Slots(#[from] SlotsError),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl RunError for ProcessError {
    fn is_lasting(&self) -> bool {
        match self {
            // A cell file does not become valid by a restart; a full disk may be freed
            // meanwhile.
            Self::Task(_) => true,
            Self::Slots(_) => false,
            Self::Bus(error) => error.is_lasting(),
        }
    }
}

/// Runs the task until a stop is requested.
///
/// # Errors
///
/// When the policy is unknown, the two-slot file cannot be mapped, or the bus
/// cannot be joined.
pub fn run(start: &Start, policies: &Policies) -> Result<(), ProcessError> {
    // The task first: an error in its files ends the process before it is seen on the bus.
    let task = policies.task(&start.cell, &start.spec.policy)?;
    let slots = Slots::open(&start.spec.run_dir, start.spec.run)?;
    let bus = start.join(Process::Task)?;
    let mut bell = bus.sleeper(Process::Task)?;
    let mut process = TaskProcess::new(&bus, task, slots, start, Monotonic)?;
    // Pages are mapped before the loop: a page fault would delay a decision.
    start.populate();
    cell_worker::run(&mut process, &mut bell);
    process.message_file.end();
    Ok(())
}

/// The loop of a modelled task, whose checkpoints are in `files`.
///
/// # Errors
///
/// When the policy is unknown, or the bus has no such topics.
pub fn model<C: Clock>(
    start: &Start,
    bus: &Bus,
    policies: &Policies,
    files: &ModelFiles,
    clock: C,
) -> Result<impl Turn + use<C>, ProcessError> {
    let task = policies.task(&start.cell, &start.spec.policy)?;
    let slots = Slots::model(files, start.spec.run)?;
    Ok(TaskProcess::new(bus, task, slots, start, clock)?)
}

struct TaskProcess<C> {
    decider: Decider,
    slots: Slots,
    message_file: MessageFile,
    state: Subscriber<WorldState>,
    /// By arm.
    statuses: Vec<Gated<ArmStatus>>,
    decision: Publisher<Decision>,
    trace: Publisher<TraceLine>,
    keyframes: Keyframes,
    lines: Vec<TraceLineText>,
    bells: Vec<Doorbell>,
    class: LoopClass,
    health: HealthReporter,
    clock: C,
    awaits: Await,
    message: Decision,
    begun: bool,
    /// Whether an earlier process of this task ran in this cell.
    is_successor: bool,
    /// The lost checkpoints that were reported last.
    lost: String,
    pictures: Pictures,
}

/// The message that has to arrive before the task continues.
#[derive(Clone, Copy)]
enum Await {
    /// A state on which a decision is due.
    State,
    /// In lockstep the statuses of this arm and those after it, for a decision that began at
    /// this time.
    Statuses(usize, u64),
}

impl<C: Clock> Turn for TaskProcess<C> {
    /// Reads the newest state and decides if a decision is due. All of it is one turn, unless
    /// lockstep has to wait for a status.
    fn turn(&mut self, woken: Woken) -> Wait {
        if self.takes_state() {
            self.awaits = Await::State;
            if self.is_due() {
                self.forget_statuses();
                self.awaits = Await::Statuses(0, self.clock.now_ns());
            }
        }
        if let Await::Statuses(arm, began_ns) = self.awaits {
            let given_up = woken.now_ns > began_ns + DELIVERY_NS;
            if let Err(arm) = self.take_statuses(arm, given_up) {
                self.awaits = Await::Statuses(arm, began_ns);
                // Another process may wait for this process in the same way.
                self.decision.update_connections();
                // The wait may be as long as the launcher waits for the first sign of life.
                let tick = self.decider.decided().map_or(0, |(_, tick)| tick);
                self.health.idle();
                self.health.publish_if_due(tick, woken.now_ns);
                return Wait::Yield;
            }
            self.awaits = Await::State;
            self.decide(began_ns);
        }
        self.finish()
    }
}

impl<C: Clock> TaskProcess<C> {
    fn new(bus: &Bus, task: Task, slots: Slots, start: &Start, clock: C) -> Result<Self, BusError> {
        let fifo = start.real_time_priority(TASK_PRIORITY);
        let mut bells = vec![bus.doorbell(Process::Physics)?];
        // Controllers wait for the decision in lockstep, so their doorbells ring with it, too.
        let mut statuses = Vec::new();
        for arm in 0..start.spec.arms {
            bells.push(bus.doorbell(Process::Controller(arm))?);
            statuses.push(Gated::new(bus.subscriber(TopicId::ArmStatus(arm))?));
        }
        Ok(Self {
            decider: Decider::new(task),
            slots,
            message_file: MessageFile::open(&start.spec.run_dir),
            state: bus.subscriber(TopicId::WorldState)?,
            statuses,
            decision: bus.publisher(TopicId::Decision)?,
            trace: bus.publisher(TopicId::Trace)?,
            keyframes: Keyframes::new(bus.publisher(TopicId::Keyframe(Process::Task))?),
            lines: Vec::with_capacity(ROOM_FOR_LINES),
            bells,
            class: LoopClass::new(start, TASK_PRIORITY, fifo),
            health: HealthReporter::new(start, bus, Process::Task, fifo, clock.now_ns())?,
            clock,
            awaits: Await::State,
            message: Decision::zeroed(),
            begun: false,
            // The launcher counts the starts of a process; the first one has no predecessor.
            is_successor: start.generation > 1,
            lost: String::new(),
            pictures: Pictures::default(),
        })
    }

    /// Ends a turn.
    fn finish(&mut self) -> Wait {
        let now_ns = self.clock.now_ns();
        self.draw_while_nothing_moves(now_ns);
        let counts = self.state.counts();
        self.health.totals(0, counts.rejected, counts.fenced);
        self.health
            .refused("state", self.state.take_invalid(), now_ns);
        self.health
            .publish_if_due(self.decider.decided().map_or(0, |(_, tick)| tick), now_ns);
        // Processes that started since the last turn receive the newest decision from here.
        self.decision.update_connections();
        self.trace.update_connections();
        // Every turn counts, also one that finds the same state again: a task whose turns stop
        // counting is reported as hung.
        self.health.idle();
        Wait::Bell
    }

    /// Whether a decision on the newest state is due.
    fn is_due(&mut self) -> bool {
        // Without a valid state there is nothing to decide on; the subscriber keeps the newest
        // one.
        let Some(state) = self.state.current() else {
            return false;
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let lockstep = state.has(FLAG_LOCKSTEP);
        self.class.follow(lockstep);
        self.health.set_lockstep(lockstep);
        // Once, at the first state: the checkpoint can only be compared with a state.
        if !self.begun {
            self.begun = true;
            self.begin();
            // The recorder gets a checkpoint at once, so that a replay can start here and not
            // only at the next second.
            let checkpoint = self.decider.task.checkpoint();
            self.send_keyframe(checkpoint);
        }
        // In real time a state of a tenth tick may be missed; the next one is used instead, so
        // that no decision is left out. In lockstep every tenth tick is seen, and only it
        // counts.
        match self.decider.decided() {
            Some((g, last)) if g == generation && tick >= last => {
                let on_the_tick = tick.is_multiple_of(DECISION_TICKS) && tick > last;
                on_the_tick || (!lockstep && tick / DECISION_TICKS > last / DECISION_TICKS)
            }
            _ => !lockstep || tick.is_multiple_of(DECISION_TICKS),
        }
    }

    /// Takes the newest state; true if it is another one than that of a decision in progress. That
    /// of a new physics ends the wait for statuses of the old one, which will not come.
    fn takes_state(&mut self) -> bool {
        let waits = matches!(self.awaits, Await::Statuses(..));
        let id = |header: &Header| (header.generation, header.tick);
        let before = self.state.current().map(|state| id(&state.header));
        self.state
            .take()
            .is_some_and(|state| !waits || before != Some(id(&state.header)))
    }

    /// Resumes from the checkpoint of the process before, if there is one.
    fn begin(&mut self) {
        let Some(state) = self.state.current() else {
            return;
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let Some(saved) = self.slots.newest(generation) else {
            // A predecessor that was killed before its first decision left no checkpoint.
            let decided = tick > state.resumed_tick + DECISION_TICKS;
            if self.is_successor && decided {
                self.slots.miss_checkpoint();
            }
            // No checkpoint of this start of physics: the history may have one for the state
            // from which physics resumed.
            let begun = self.decider.begin(state, &mut self.slots);
            let restored = self.decider.task.restored();
            self.report(&begun, restored, tick);
            return;
        };
        let decided = (generation, saved.tick);
        match self.decider.resume(&saved.checkpoint, decided, state) {
            Ok(()) => self.say(tick, self.decider.task.restored().line()),
            Err(error) => {
                // The memory is lost; the observation is not.
                cell_worker::warn(format_args!("{error}"));
                self.say(tick, "[task] started without a checkpoint");
                return;
            }
        }
        // The saved decision is the message that is repeated.
        self.message = saved.decision;
        // The decision was made, but perhaps not received by all. It is absolute, and its tick
        // gives its age. Another decision follows.
        let _sent = self.publish();
    }

    /// Decides on the newest state, with the statuses that were taken.
    fn decide(&mut self, began_ns: u64) {
        let Some(state) = self.state.current() else {
            return;
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let mut statuses = [None; MAX_ARMS];
        for (slot, input) in statuses.iter_mut().zip(&self.statuses) {
            *slot = input.get(generation);
        }
        self.lines.clear();
        let begun = self.decider.begin(state, &mut self.slots);
        let restored = self.decider.task.restored();
        let message = &mut self.message;
        self.decider
            .decide(state, &statuses, message, &mut self.lines);
        let warnings = self.decider.task.take_warnings();
        warnings.iter().for_each(cell_worker::warn);
        // Before `publish`: a run ends with the decision that reports a failure.
        self.message_file.decided(&self.decider.task);
        let checkpoint = self.decider.task.checkpoint();
        // Before `publish`: a successor must know every decision that a reader may have.
        self.slots.write(generation, tick, message, &checkpoint);
        self.report(&begun, restored, tick);
        self.report_lost(tick);
        let sent = self.publish();
        // Decisions of a resumed task depend on a checkpoint that the recording does not have
        // yet.
        let is_resumed = !matches!(begun, Begun::Continued | Begun::Reconciled);
        // States between two tenth ticks are recorded in part only, so a decision on one needs
        // a checkpoint, too.
        let is_between = !tick.is_multiple_of(DECISION_TICKS);
        if sent && (self.keyframes.is_due(tick, is_between) || is_resumed) {
            self.send_keyframe(checkpoint);
        }
        self.send_part();
        // Pictures and lines are for people: sent after the messages that the cell waits for.
        self.draw(tick);
        self.send_lines(tick);
        let outcome = f64::from(self.message.outcome);
        let (values, now_ns) = ([outcome, 0.0, 0.0, 0.0], self.clock.now_ns());
        self.health.cycle(tick, began_ns, 0, values, now_ns);
    }

    /// Removes the statuses of before if physics was restarted or the scene was reset.
    // Called before `begin`, which takes note of the new start.
    fn forget_statuses(&mut self) {
        let newest = self.state.current().map(|state| state.header);
        let is_back = |(g, t)| newest.is_none_or(|new| g != new.generation || t > new.tick);
        if self.decider.decided().is_none_or(is_back) {
            self.statuses.iter_mut().for_each(Gated::clear);
        }
    }

    /// Reads the newest status, caused by an earlier tick, of `arm` and those after it. The
    /// error is the arm whose status of the tick before is missing in lockstep, unless that was
    /// `given_up`.
    fn take_statuses(&mut self, arm: usize, given_up: bool) -> Result<(), usize> {
        let Some(state) = self.state.current() else {
            return Ok(());
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let waits = state.has(FLAG_LOCKSTEP) && !given_up;
        // Before its first tick this start of physics was sent none.
        let wanted = tick
            .checked_sub(1)
            .filter(|tick| *tick >= state.resumed_tick);
        for (arm, input) in self.statuses.iter_mut().enumerate().skip(arm) {
            // The status of this tick is kept back even if it arrived: which one arrives first
            // would depend on the scheduler (ADR 0004).
            if !input.choose(generation, tick, wanted) && waits {
                return Err(arm);
            }
        }
        Ok(())
    }

    /// Publishes the decision and rings the doorbells. `false` if it was not sent: another
    /// one follows on the next tenth tick.
    fn publish(&mut self) -> bool {
        let message = &self.message;
        let sent = self.decision.publish(|slot| *slot = *message).is_ok();
        self.bells.iter_mut().for_each(Doorbell::ring);
        sent
    }

    /// Starts to record the checkpoint, as of the newest decision.
    fn send_keyframe(&mut self, checkpoint: Vec<u8>) {
        let after_seq = self.decision.seq();
        self.keyframes
            .begin(checkpoint, &self.message.header, after_seq);
    }

    fn send_part(&mut self) {
        if !self.keyframes.send() {
            self.health
                .note("a checkpoint could not be recorded: `replay --verify` skips a part");
        }
    }
}
