//! The controller on the bus: one cycle for each new state.
//!
//! A command that is late or doubled makes physics brake the arm, so these rules hold:
//!
//! - In real time a cycle never waits for the task or the planner. It uses the newest
//!   decision, whose age decides on a stop.
//! - In lockstep it uses exactly the decision of the last tenth tick, and the answer of the
//!   planner at its tick, with any scheduling (ADR 0004). It waits for both.
//! - Decisions that answer another generation of physics are ignored.
//! - The status is published before the command: physics continues when it has the command,
//!   and then the task must find the status of that tick.
//! - The thread of the planner starts before this thread gets real-time scheduling, which it
//!   would inherit.

use std::time::Duration;

use cell_bus::{Bus, BusError, Doorbell, Gate, Publisher, Sleeper, Subscriber};
use cell_model::stop::{DECISION_AGE_FIFO_TICKS, DECISION_AGE_OTHER_TICKS};
use cell_rt::periodic::{SPIN_FIFO_NS, SPIN_OTHER_NS};
use cell_rt::priority::CONTROLLER_PRIORITY;
use cell_rt::signal::stop_requested;
use cell_rt::{monotonic_ns, sleep_until};
use cell_worker::{HealthReporter, LoopClass, RunError, Start};
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_LOCKSTEP;
use ipc_types::{
    ArmCommand, ArmStatus, DECISION_TICKS, Decision, Header, Keyframe, TICK_NS, Wire, WorldState,
};

use crate::controllers::Controllers;
use crate::cycle::Cycle;
use crate::planning::Planner;
use crate::planning::worker::PlanWorker;
use crate::rmpflow_controller::RmpFlowError;

/// How long lockstep polls before it sleeps (ns): longer than a step of physics.
// Sleeping costs two switches of context in each tick.
const SPIN_LOCKSTEP_NS: u64 = 300_000;
/// Longest sleep of a waiting controller; then it serves subscribers that joined late.
const NUDGE: Duration = Duration::from_millis(5);
/// Longest wait for a state in real time (ns); after it the turn ends without a cycle.
// Five ticks: health is reported and late subscribers are served while physics is away.
const PATIENCE_NS: u64 = 5_000_000;
/// Interval of the checkpoints for replay (ticks).
// A replay starts at a checkpoint, at most a second before the tick of interest.
const KEYFRAME_TICKS: u64 = 1000;
/// Longest wait of lockstep for a decision that was sent, but not yet to this reader (ns): its
/// writer may have been killed in between and has to start again.
const DELIVERY_NS: u64 = 2_000_000_000;

/// Why a controller cannot run.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The robot's tuning.
    #[error(transparent)]
    Tuning(#[from] RmpFlowError),
    /// The thread of the planner.
    #[error("the thread of the planner cannot be started: {0}; allow this user more threads")]
    Planner(std::io::Error),
    /// The bus.
    #[error(transparent)]
    Bus(#[from] BusError),
}

impl RunError for ProcessError {
    fn is_lasting(&self) -> bool {
        match self {
            Self::Tuning(_) => true,
            Self::Planner(_) => false,
            Self::Bus(error) => error.is_lasting(),
        }
    }
}

/// Runs the controller until it is asked to stop.
///
/// # Errors
///
/// When the cell has no such arm, the tuning does not fit the robot, the thread of the planner
/// cannot be started, or the bus cannot be joined.
pub fn run(start: &Start, controllers: &Controllers) -> Result<(), ProcessError> {
    let cycle = Cycle::with(&start.cell, usize::from(start.arm), controllers)?;
    // Before this thread gets its priority, which a new thread would inherit.
    let planner = Planner::new(&start.cell, usize::from(start.arm))?;
    let planner = PlanWorker::start(planner, &cycle).map_err(ProcessError::Planner)?;
    let fifo = start.real_time(CONTROLLER_PRIORITY, 1 + usize::from(start.arm));
    let bus = start.join(Process::Controller(start.arm))?;
    let mut process = ControllerProcess::new(start, &bus, (cycle, planner), fifo)?;
    start.populate();
    while !stop_requested() {
        process.turn();
    }
    Ok(())
}

struct ControllerProcess {
    cycle: Cycle,
    planner: PlanWorker,
    state: Subscriber<WorldState>,
    decision: Subscriber<Decision>,
    gate: Gate<Decision>,
    command: Publisher<ArmCommand>,
    status: Publisher<ArmStatus>,
    keyframe: Publisher<Keyframe>,
    sent: ArmCommand,
    report: ArmStatus,
    physics_bell: Doorbell,
    task_bell: Doorbell,
    sleeper: Sleeper,
    health: HealthReporter,
    spin_ns: u64,
    decision_limit_ticks: u64,
    /// Generation of physics and tick that were answered last.
    answered: Option<(u32, u64)>,
    lockstep: bool,
    class: LoopClass,
    expected_ns: u64,
    /// Second of simulated time of the last checkpoint that was sent.
    kept_in: Option<u64>,
}

impl ControllerProcess {
    fn new(
        start: &Start,
        bus: &Bus,
        (cycle, planner): (Cycle, PlanWorker),
        fifo: bool,
    ) -> Result<Self, BusError> {
        let arm = start.arm;
        // Without real-time scheduling the task is late more often; a hold at each delay would
        // stop the work.
        let limit = if fifo {
            DECISION_AGE_FIFO_TICKS
        } else {
            DECISION_AGE_OTHER_TICKS
        };
        let mut process = Self {
            cycle,
            planner,
            state: bus.subscriber(TopicId::WorldState)?,
            decision: bus.subscriber(TopicId::Decision)?,
            gate: Gate::new(),
            command: bus.publisher(TopicId::ArmCommand(arm))?,
            status: bus.publisher(TopicId::ArmStatus(arm))?,
            keyframe: bus.publisher(TopicId::Keyframe(Process::Controller(arm)))?,
            sent: ArmCommand::zeroed(),
            report: ArmStatus::zeroed(),
            physics_bell: bus.doorbell(Process::Physics)?,
            task_bell: bus.doorbell(Process::Task)?,
            sleeper: bus.sleeper(Process::Controller(arm))?,
            health: HealthReporter::new(start, bus, Process::Controller(arm), fifo)?,
            spin_ns: if fifo { SPIN_FIFO_NS } else { SPIN_OTHER_NS },
            decision_limit_ticks: limit,
            answered: None,
            lockstep: false,
            class: LoopClass::new(CONTROLLER_PRIORITY, fifo),
            expected_ns: 0,
            kept_in: None,
        };
        // The state before the first command, so that a replay can start there.
        process.publish_keyframe(&Header::zeroed());
        Ok(process)
    }

    /// Waits for the next state and answers it.
    fn turn(&mut self) {
        let waited = self.wait_for_state();
        let woke_ns = monotonic_ns();
        if let Some((generation, tick)) = waited.then(|| self.newest()).flatten()
            // The same state may be delivered twice; a second answer would move the setpoint
            // twice.
            && self.answered != Some((generation, tick))
        {
            self.answer(generation, tick);
        }
        // Before the first state nothing is expected, so nothing is late.
        let expected_ns = if self.expected_ns == 0 {
            woke_ns
        } else {
            self.expected_ns
        };
        // In lockstep the time of a state depends on all processes, so lateness means nothing.
        let late_ns = if self.lockstep {
            0
        } else {
            woke_ns.saturating_sub(expected_ns)
        };
        self.expected_ns = woke_ns + TICK_NS;
        if waited {
            let tick = self.answered.map_or(0, |(_, tick)| tick);
            self.health
                .cycle(tick, woke_ns, late_ns, self.boxed_values());
        } else {
            self.health.idle();
            // A subscriber that joined late gets the newest message only by this call.
            self.command.update_connections();
            self.status.update_connections();
        }
        let now_ns = monotonic_ns();
        let counts = self.decision.counts();
        let states = self.state.counts();
        let missed = self.report.missed_cycles;
        self.health.totals(
            missed,
            counts.rejected + states.rejected,
            counts.fenced + states.fenced,
        );
        self.health
            .refused("decision", self.decision.take_invalid(), now_ns);
        self.health
            .refused("state", self.state.take_invalid(), now_ns);
        self.health
            .publish_if_due(self.answered.map_or(0, |(_, tick)| tick), now_ns);
    }

    /// Values of a cycle that the black box keeps for an incident.
    fn boxed_values(&self) -> [f64; 4] {
        let speeds = self.sent.joint_velocities;
        [
            f64::from(self.report.stop_action),
            self.report.decision_age_ticks as f64,
            speeds
                .iter()
                .fold(0.0, |top: f64, speed| top.max(speed.abs())),
            self.report.position_error,
        ]
    }

    /// The cycle: take the newest inputs, update ([`Cycle::update`]), publish.
    fn answer(&mut self, generation: u32, tick: u64) {
        // Time went back: decisions about later ticks belong to a run that was set back.
        if self
            .answered
            .is_none_or(|(g, t)| g != generation || t > tick)
        {
            self.gate.clear();
        }
        let decided = self.take_decision(generation, tick);
        let Some(state) = self.state.current() else {
            return;
        };
        let decision = decided.then(|| self.gate.current()).flatten();
        let lockstep = self.lockstep;
        // In real time the closure ends the wait at once, and the answer is taken when it
        // arrives.
        self.planner.deliver(&mut self.cycle, tick, || {
            std::thread::yield_now();
            lockstep && !stop_requested()
        });
        let (command, report) = (&mut self.sent, &mut self.report);
        self.cycle
            .update(state, decision, self.decision_limit_ticks, command, report);
        // After the update, which made the request: the planner has all of the interval for
        // it.
        self.planner.hand_over(&self.cycle);
        // Status before command: a process that has the command may rely on the status.
        let _sent = self.status.publish(|message| *message = *report).is_ok();
        let sent = self.command.publish(|message| *message = *command).is_ok();
        self.answered = Some((generation, tick));
        if self.lockstep {
            self.physics_bell.ring();
            self.task_bell.ring();
        }
        // A command that was not sent has no sequence number for the checkpoint to follow.
        if sent && self.kept_in != Some(tick / KEYFRAME_TICKS) {
            self.kept_in = Some(tick / KEYFRAME_TICKS);
            let of_command = self.sent.header;
            self.publish_keyframe(&of_command);
        }
    }

    /// Publishes a checkpoint for replay, as of the newest command, whose header is
    /// `of_command`.
    fn publish_keyframe(&mut self, of_command: &Header) {
        let (cycle, limit) = (&mut self.cycle, self.decision_limit_ticks);
        let after_seq = self.command.seq();
        let mut fits = true;
        let sent = self.keyframe.publish(|message| {
            message.header = Header {
                inputs: of_command.inputs,
                input_count: of_command.input_count,
                ..Header::caused_by::<Keyframe>(of_command.tick)
            };
            message.after_seq = after_seq;
            message.reserved = 0;
            let length = cycle.save(limit, &mut message.bytes).ok();
            fits = length.is_some();
            // The length fits: the array has that many bytes.
            message.len = length.map_or(0, |length| u32::try_from(length).unwrap_or(0));
            (message.offset, message.total) = (0, u64::from(message.len));
        });
        if !fits || sent.is_err() {
            self.health
                .note("the controller's checkpoint could not be kept: no replay verifies this run");
        }
    }

    /// Takes the newest decision caused by an earlier tick of this physics; `true` if one was
    /// found. In lockstep that is the decision of the last tenth tick, and it is waited for.
    fn take_decision(&mut self, generation: u32, tick: u64) -> bool {
        // The decision of this tick itself is kept back: whether it has arrived depends on the
        // scheduler.
        let wanted = tick.checked_sub(1).map(|t| t - t % DECISION_TICKS);
        let patient_until_ns = monotonic_ns() + DELIVERY_NS;
        loop {
            self.gate.pull(&mut self.decision);
            let found = self
                .gate
                .advance(tick)
                .filter(|d| d.header.answers(generation));
            let complete = found.map(|d| d.header.tick) >= wanted;
            if !self.lockstep || complete || monotonic_ns() > patient_until_ns || stop_requested() {
                return found.is_some();
            }
            std::thread::yield_now();
        }
    }

    fn newest(&self) -> Option<(u32, u64)> {
        self.state
            .current()
            .map(|s| (s.header.generation, s.header.tick))
    }

    /// Waits for a new state; `false` on a timeout.
    fn wait_for_state(&mut self) -> bool {
        if self.lockstep {
            self.wait_in_lockstep()
        } else {
            self.wait_in_real_time()
        }
    }

    /// Sleeps until shortly before the next state is due, then polls.
    fn wait_in_real_time(&mut self) -> bool {
        // Sleeping is not exact enough for the start of a cycle; polling all the time takes a
        // core.
        sleep_until(self.expected_ns.saturating_sub(self.spin_ns));
        let patient_until_ns = monotonic_ns() + PATIENCE_NS;
        loop {
            if self.take_state() {
                return true;
            }
            let now_ns = monotonic_ns();
            if now_ns > patient_until_ns || stop_requested() {
                return false;
            }
            if now_ns > self.expected_ns + self.spin_ns {
                // Overdue: physics is late, starting, or not running. Polling would take its
                // core.
                sleep_until(now_ns + self.spin_ns);
            } else {
                std::hint::spin_loop();
            }
        }
    }

    fn wait_in_lockstep(&mut self) -> bool {
        let patient_until_ns = monotonic_ns() + SPIN_LOCKSTEP_NS;
        while monotonic_ns() < patient_until_ns {
            if self.take_state() {
                return true;
            }
            std::thread::yield_now();
        }
        self.sleeper.wait(NUDGE);
        self.take_state()
    }

    fn take_state(&mut self) -> bool {
        let Some(state) = self.state.take() else {
            return false;
        };
        // The mode is part of the state: it changes with the speed, at a known tick.
        self.lockstep = state.has(FLAG_LOCKSTEP);
        self.class.follow(self.lockstep);
        self.health.set_lockstep(self.lockstep);
        true
    }
}
