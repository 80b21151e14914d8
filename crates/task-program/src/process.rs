//! The task on the bus: on every tenth tick observe, decide, write it down,
//! publish.

use std::time::Duration;

use cell_bus::{Bus, BusError, Doorbell, Gate, Publisher, Sleeper, Subscriber};
use cell_rt::{monotonic_ns, priority::TASK_PRIORITY, signal::stop_requested};
use cell_worker::{HealthReporter, LoopClass, RunError, Start};
use ipc_types::topic::{Process, TopicId};
use ipc_types::trace::{TraceEvent, TraceKind};
use ipc_types::world::FLAG_LOCKSTEP;
use ipc_types::{
    ArmStatus, DECISION_TICKS, Decision, Header, MAX_ARMS, TICK_NS, TraceLine, Wire, WorldState,
};

use robocell_task::output::ROOM_FOR_LINES;
use robocell_task::starts::{Begun, Decider};
use robocell_task::{Policies, Restored, Task, TaskError, TraceLineText};

use crate::keyframes::Keyframes;
use crate::message_file::MessageFile;
use crate::slots::{Slots, SlotsError};

/// Longest sleep between two looks at the state.
const NUDGE: Duration = Duration::from_millis(5);
/// Longest wait of lockstep for the controllers' words on the tick before, which
/// were sent, but perhaps not yet to this reader (ns).
const DELIVERY_NS: u64 = 2_000_000_000;

/// How often the statuses of all nodes are sent (ticks).
const STATUS_TICKS: u64 = 100;
/// How often the pictures are sent (ticks).
const PICTURE_TICKS: u64 = 1000;

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
            Self::Task(_) => true,
            Self::Slots(_) => false,
            Self::Bus(error) => error.is_lasting(),
        }
    }
}

/// Runs the task until it is asked to stop.
///
/// # Errors
///
/// When the policy is unknown, the two-slot file cannot be mapped, or the bus
/// cannot be joined.
pub fn run(start: &Start, policies: &Policies) -> Result<(), ProcessError> {
    let task = policies.task(&start.cell, &start.spec.policy)?;
    let slots = Slots::open(&start.spec.run_dir, start.spec.run)?;
    let bus = start.join(Process::Task)?;
    let mut process = TaskProcess::new(&bus, task, slots, start)?;
    start.populate();
    while !stop_requested() {
        process.turn();
    }
    Ok(())
}

struct TaskProcess {
    decider: Decider,
    slots: Slots,
    message_file: MessageFile,
    state: Subscriber<WorldState>,
    statuses: Vec<(Subscriber<ArmStatus>, Gate<ArmStatus>)>,
    decision: Publisher<Decision>,
    trace: Publisher<TraceLine>,
    keyframes: Keyframes,
    lines: Vec<TraceLineText>,
    bells: Vec<Doorbell>,
    sleeper: Sleeper,
    class: LoopClass,
    health: HealthReporter,
    message: Decision,
    begun: bool,
    /// Whether another process of this task ran before.
    is_successor: bool,
    /// What was reported as lost last.
    lost: String,
    /// Tick the pictures were sent at last, and when that was (ns).
    drawn: Option<u64>,
    drawn_ns: u64,
}

impl TaskProcess {
    fn new(bus: &Bus, task: Task, slots: Slots, start: &Start) -> Result<Self, BusError> {
        let fifo = start.real_time_priority(TASK_PRIORITY);
        let mut bells = vec![bus.doorbell(Process::Physics)?];
        let mut statuses = Vec::new();
        for arm in 0..start.spec.arms {
            bells.push(bus.doorbell(Process::Controller(arm))?);
            statuses.push((bus.subscriber(TopicId::ArmStatus(arm))?, Gate::new()));
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
            sleeper: bus.sleeper(Process::Task)?,
            class: LoopClass::new(TASK_PRIORITY, fifo),
            health: HealthReporter::new(start, bus, Process::Task, fifo)?,
            message: Decision::zeroed(),
            begun: false,
            is_successor: start.generation > 1,
            lost: String::new(),
            drawn: None,
            drawn_ns: 0,
        })
    }

    /// Looks at the newest state and decides if it is time to.
    fn turn(&mut self) {
        if self.state.take().is_some() {
            self.work();
        }
        let now_ns = monotonic_ns();
        self.draw_while_nothing_moves(now_ns);
        let counts = self.state.counts();
        self.health.totals(0, counts.rejected, counts.fenced);
        self.health
            .refused("state", self.state.take_invalid(), now_ns);
        self.health
            .publish_if_due(self.decider.decided().map_or(0, |(_, tick)| tick), now_ns);
        self.decision.update_connections();
        self.trace.update_connections();
        // Every turn counts, also one that finds the same state again: a task
        // whose cycles stand still hangs.
        self.health.idle();
        self.sleeper.wait(NUDGE);
    }

    fn work(&mut self) {
        let Some(state) = self.state.current() else {
            return;
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let lockstep = state.has(FLAG_LOCKSTEP);
        self.class.follow(lockstep);
        self.health.set_lockstep(lockstep);
        if !self.begun {
            self.begun = true;
            self.begin();
            let checkpoint = self.decider.task.checkpoint();
            self.send_keyframe(checkpoint);
        }
        let due = match self.decider.decided() {
            Some((g, last)) if g == generation && tick >= last => {
                let on_the_tick = tick.is_multiple_of(DECISION_TICKS) && tick > last;
                on_the_tick || (!lockstep && tick / DECISION_TICKS > last / DECISION_TICKS)
            }
            _ => !lockstep || tick.is_multiple_of(DECISION_TICKS),
        };
        if due {
            self.decide(generation, tick, lockstep);
        }
    }

    /// Resumes from the checkpoint of the process before, if there is one.
    fn begin(&mut self) {
        let Some(state) = self.state.current() else {
            return;
        };
        let (generation, tick) = (state.header.generation, state.header.tick);
        let Some(saved) = self.slots.newest(generation) else {
            // One that was killed before its first decision left none.
            let decided = tick > state.resumed_tick + DECISION_TICKS;
            if self.is_successor && decided {
                self.slots.miss_checkpoint();
            }
            let begun = self.decider.begin(state, &mut self.slots);
            let restored = self.decider.task.restored();
            self.report(&begun, restored, tick);
            return;
        };
        let decided = (generation, saved.tick);
        match self.decider.resume(&saved.checkpoint, decided, state) {
            Ok(()) => self.say(tick, self.decider.task.restored().line()),
            Err(error) => {
                // What happened before is lost; what is seen is not.
                cell_worker::warn(format_args!("{error}"));
                self.say(tick, "[task] started without a checkpoint");
                return;
            }
        }
        self.message = saved.decision;
        // The decision was made, perhaps not heard, or not by all. It is
        // absolute, and its tick says how old it is. Another one follows.
        let _sent = self.publish();
    }

    fn report(&mut self, begun: &Begun, restored: Restored, tick: u64) {
        match begun {
            Begun::Resumed if restored == Restored::All => {
                self.say(tick, "[task] resumed where physics resumed");
            }
            Begun::Resumed => self.say(tick, restored.line()),
            Begun::Lost(error) => {
                cell_worker::warn(format_args!("{error}"));
                self.say(tick, "[task] started without a checkpoint");
            }
            Begun::Continued | Begun::Reconciled | Begun::NewScene => {}
        }
    }

    fn decide(&mut self, generation: u32, tick: u64, lockstep: bool) {
        let began_ns = monotonic_ns();
        self.take_statuses(generation, tick, lockstep);
        let Some(state) = self.state.current() else {
            return;
        };
        let mut statuses = [None; MAX_ARMS];
        for (slot, (_, gate)) in statuses.iter_mut().zip(&self.statuses) {
            *slot = gate.current().filter(|s| s.header.answers(generation));
        }
        self.lines.clear();
        let begun = self.decider.begin(state, &mut self.slots);
        let restored = self.decider.task.restored();
        let message = &mut self.message;
        self.decider
            .decide(state, &statuses, message, &mut self.lines);
        self.message_file.decided(&self.decider.task);
        let checkpoint = self.decider.task.checkpoint();
        self.slots.write(generation, tick, message, &checkpoint);
        self.report(&begun, restored, tick);
        self.report_lost(tick);
        let sent = self.publish();
        let is_resumed = !matches!(begun, Begun::Continued | Begun::Reconciled);
        if sent && (self.keyframes.is_due(tick) || is_resumed) {
            self.send_keyframe(checkpoint);
        }
        self.send_part();
        self.draw(tick);
        self.send_lines(tick);
        let outcome = f64::from(self.message.outcome);
        self.health
            .cycle(tick, began_ns, 0, [outcome, 0.0, 0.0, 0.0]);
    }

    /// In the health of the process, and in the trace when it changes.
    fn report_lost(&mut self, tick: u64) {
        let lost = self.slots.lost();
        if self.lost == lost {
            return;
        }
        self.lost = lost.to_owned();
        self.health.fault((!lost.is_empty()).then_some(lost));
        if !self.lost.is_empty() {
            let line = format!("[task] {}", self.lost);
            self.say(tick, &line);
        }
    }

    /// Says at 10 Hz how every node stands, and once a second what the nodes
    /// are, for who has just begun to look.
    fn draw(&mut self, tick: u64) {
        if self
            .drawn
            .is_none_or(|drawn| tick >= drawn + PICTURE_TICKS || tick < drawn)
        {
            self.drawn = Some(tick);
            self.drawn_ns = monotonic_ns();
            self.decider.task.trace_pictures(&mut self.lines);
        }
        if tick.is_multiple_of(STATUS_TICKS) {
            self.decider.task.trace_statuses(&mut self.lines);
        }
    }

    /// Simulated time stands still while the cell is paused; who begins to look
    /// then wants to see the task, too.
    fn draw_while_nothing_moves(&mut self, now_ns: u64) {
        let Some((_, tick)) = self.decider.decided() else {
            return;
        };
        if now_ns < self.drawn_ns + PICTURE_TICKS * TICK_NS {
            return;
        }
        self.drawn = None;
        self.lines.clear();
        self.draw(tick);
        self.send_lines(tick);
    }

    fn send_lines(&mut self, tick: u64) {
        let lines = std::mem::take(&mut self.lines);
        for line in &lines {
            self.send_line(tick, line);
        }
        self.lines = lines;
    }

    /// The newest status caused by an earlier tick; in lockstep that of the
    /// tick before, which is waited for.
    fn take_statuses(&mut self, generation: u32, tick: u64, lockstep: bool) {
        let patient_until_ns = monotonic_ns() + DELIVERY_NS;
        if self
            .decider
            .decided()
            .is_none_or(|(g, t)| g != generation || t > tick)
        {
            self.statuses.iter_mut().for_each(|(_, gate)| gate.clear());
        }
        for (subscriber, gate) in &mut self.statuses {
            loop {
                gate.pull(subscriber);
                let found = gate.advance(tick).filter(|s| s.header.answers(generation));
                let complete = found.map(|s| s.header.tick) >= tick.checked_sub(1);
                let given_up = monotonic_ns() > patient_until_ns || stop_requested();
                if !lockstep || complete || given_up {
                    break;
                }
                // Another process may wait for this process in the same way.
                self.decision.update_connections();
                std::thread::yield_now();
            }
        }
    }

    /// `false` for a decision that was not sent: it is followed by another on the
    /// next tenth tick.
    fn publish(&mut self) -> bool {
        let message = &self.message;
        let sent = self.decision.publish(|slot| *slot = *message).is_ok();
        self.bells.iter_mut().for_each(Doorbell::ring);
        sent
    }

    /// Records the checkpoint, as of the newest decision.
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

    fn say(&mut self, tick: u64, text: &str) {
        let line = TraceLineText {
            kind: TraceKind::Lifecycle,
            graph: 0,
            node: 0,
            from: 0,
            to: 0,
            event: TraceEvent::Restart,
            text: ipc_types::Text::new(text),
        };
        self.send_line(tick, &line);
    }

    fn send_line(&mut self, tick: u64, line: &TraceLineText) {
        let write = |message: &mut TraceLine| {
            message.header = Header::caused_by::<TraceLine>(tick);
            message.kind = line.kind.code();
            message.graph = u32::try_from(line.graph).unwrap_or(u32::MAX);
            message.node = u32::try_from(line.node).unwrap_or(u32::MAX);
            message.from = line.from;
            message.to = line.to;
            message.event = line.event.code();
            message.text = line.text;
        };
        // A line that was not sent leaves a gap in the sequence, which counts.
        let _sent = self.trace.publish(write).is_ok();
    }
}
