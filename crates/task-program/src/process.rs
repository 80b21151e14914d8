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
    ArmStatus, DECISION_TICKS, Decision, Header, Keyframe, MAX_ARMS, TICK_NS, TraceLine, Wire,
    WorldState,
};

use robocell_task::inputs::{MISSED_TICKS, name_inputs};
use robocell_task::output::ROOM_FOR_LINES;
use robocell_task::{Policies, Task, TaskError, TraceLineText};

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
/// How often the task's checkpoint is sent (ticks).
const KEYFRAME_TICKS: u64 = 1000;

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
    task: Task,
    slots: Slots,
    state: Subscriber<WorldState>,
    statuses: Vec<(Subscriber<ArmStatus>, Gate<ArmStatus>)>,
    decision: Publisher<Decision>,
    trace: Publisher<TraceLine>,
    keyframe: Publisher<Keyframe>,
    lines: Vec<TraceLineText>,
    bells: Vec<Doorbell>,
    sleeper: Sleeper,
    class: LoopClass,
    health: HealthReporter,
    message: Decision,
    /// Generation of physics and tick decided on last.
    decided: Option<(u32, u64)>,
    begun: bool,
    /// Tick the pictures were sent at last, and when that was (ns).
    drawn: Option<u64>,
    drawn_ns: u64,
    /// Second of simulated time the checkpoint was sent in last.
    kept_in: Option<u64>,
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
            task,
            slots,
            state: bus.subscriber(TopicId::WorldState)?,
            statuses,
            decision: bus.publisher(TopicId::Decision)?,
            trace: bus.publisher(TopicId::Trace)?,
            keyframe: bus.publisher(TopicId::Keyframe(Process::Task))?,
            lines: Vec::with_capacity(ROOM_FOR_LINES),
            bells,
            sleeper: bus.sleeper(Process::Task)?,
            class: LoopClass::new(TASK_PRIORITY, fifo),
            health: HealthReporter::new(start, bus, Process::Task, fifo)?,
            message: Decision::zeroed(),
            decided: None,
            begun: false,
            drawn: None,
            drawn_ns: 0,
            kept_in: None,
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
            .publish_if_due(self.decided.map_or(0, |(_, tick)| tick), now_ns);
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
            self.begin(generation, tick);
            let checkpoint = self.task.checkpoint();
            self.publish_keyframe(&checkpoint);
        }
        let due = match self.decided {
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
    fn begin(&mut self, generation: u32, tick: u64) {
        let Some(saved) = self.slots.newest(generation) else {
            self.begin_scene();
            return;
        };
        match self.task.restore(&saved.checkpoint) {
            Ok(()) => self.say(tick, "[task] resumed from its checkpoint"),
            Err(error) => {
                // What happened before is lost; what is seen is not.
                cell_worker::warn(format_args!("{error}"));
                self.say(tick, "[task] started without a checkpoint");
                return;
            }
        }
        if tick / DECISION_TICKS > saved.tick / DECISION_TICKS + 1 {
            self.reconcile();
        }
        self.decided = Some((generation, saved.tick));
        self.message = saved.decision;
        // The decision was made, perhaps not heard, or not by all. It is
        // absolute, and its tick says how old it is. Another one follows.
        let _sent = self.publish();
    }

    /// Physics was started again: it has the state its predecessor kept, which this
    /// task remembers, or a fresh scene.
    fn begin_scene(&mut self) {
        let resumed_tick = self.state.current().map_or(0, |state| state.resumed_tick);
        let saved = self.slots.at(resumed_tick);
        let restored = saved.is_some_and(|saved| {
            let restored = self.task.restore(&saved.checkpoint);
            if let Err(error) = &restored {
                cell_worker::warn(format_args!("{error}"));
            }
            restored.is_ok()
        });
        if restored {
            self.reconcile();
            self.say(resumed_tick, "[task] resumed where physics resumed");
        } else {
            self.task.begin_new_scene();
        }
    }

    fn reconcile(&mut self) {
        if let Some(state) = self.state.current() {
            self.task.reconcile(state);
        }
    }

    fn decide(&mut self, generation: u32, tick: u64, lockstep: bool) {
        let began_ns = monotonic_ns();
        match self.decided {
            Some((known, _)) if known != generation => self.begin_scene(),
            // This process was stopped for a while.
            Some((_, last)) if tick > last + MISSED_TICKS => self.reconcile(),
            _ => {}
        }
        self.take_statuses(generation, tick, lockstep);
        let Some(state) = self.state.current() else {
            return;
        };
        let mut statuses = [None; MAX_ARMS];
        for (slot, (_, gate)) in statuses.iter_mut().zip(&self.statuses) {
            *slot = gate.current().filter(|s| s.header.answers(generation));
        }
        self.lines.clear();
        self.slots.deciding_on(generation, tick);
        self.task
            .decide(state, &statuses, &mut self.message, &mut self.lines);
        name_inputs(&mut self.message.header, state, &statuses);
        self.decided = Some((generation, tick));
        let checkpoint = self.task.checkpoint();
        if !self
            .slots
            .write(generation, tick, &self.message, &checkpoint)
        {
            self.health
                .note("the task's checkpoint is too long to be kept");
        }
        let sent = self.publish();
        if sent && self.is_keyframe_due(tick) {
            self.publish_keyframe(&checkpoint);
        }
        self.draw(tick);
        self.send_lines(tick);
        let outcome = f64::from(self.message.outcome);
        self.health
            .cycle(tick, began_ns, 0, [outcome, 0.0, 0.0, 0.0]);
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
            self.task.trace_pictures(&mut self.lines);
        }
        if tick.is_multiple_of(STATUS_TICKS) {
            self.task.trace_statuses(&mut self.lines);
        }
    }

    /// Simulated time stands still while the cell is paused; who begins to look
    /// then wants to see the task, too.
    fn draw_while_nothing_moves(&mut self, now_ns: u64) {
        let Some((_, tick)) = self.decided else {
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
            .decided
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

    /// Once a second, and after a decision between two tenth ticks: the states
    /// there are recorded in part only.
    fn is_keyframe_due(&mut self, tick: u64) -> bool {
        let second = tick / KEYFRAME_TICKS;
        let due = self.kept_in != Some(second) || !tick.is_multiple_of(DECISION_TICKS);
        self.kept_in = Some(second);
        due
    }

    /// Sends `checkpoint`, as of the newest decision, for those who compute the
    /// decisions again; its tick and inputs are in the header.
    fn publish_keyframe(&mut self, checkpoint: &[u8]) {
        let (last, after_seq) = (self.message.header, self.decision.seq());
        let mut fits = true;
        let sent = self.keyframe.publish(|message| {
            message.header = Header {
                inputs: last.inputs,
                input_count: last.input_count,
                ..Header::caused_by::<Keyframe>(last.tick)
            };
            message.after_seq = after_seq;
            message.reserved = 0;
            fits = message.set(checkpoint);
        });
        if !fits || sent.is_err() {
            self.health
                .note("the task's checkpoint could not be recorded: no replay verifies this run");
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
