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

use cell_bus::{Bus, BusError, Doorbell, Publisher, Subscriber};
use cell_model::stop::{DECISION_AGE_FIFO_TICKS, DECISION_AGE_OTHER_TICKS};
use cell_rt::periodic::{SPIN_FIFO_NS, SPIN_OTHER_NS};
use cell_rt::priority::CONTROLLER_PRIORITY;
use cell_rt::{Clock, Monotonic};
use cell_worker::{
    DELIVERY_NS, Gated, HealthReporter, Keyframes, LoopClass, RunError, Start, Turn, Wait, Woken,
};
use ipc_types::topic::{Process, TopicId};
use ipc_types::world::FLAG_LOCKSTEP;
use ipc_types::{
    ArmCommand, ArmStatus, DECISION_TICKS, Decision, Header, TICK_NS, Wire, WorldState,
};

use crate::controllers::Controllers;
use crate::cycle::Cycle;
use crate::planning::Planner;
use crate::planning::worker::PlanWorker;
use crate::rmpflow_controller::RmpFlowError;

/// How long lockstep polls before it sleeps (ns): longer than a step of physics.
// Sleeping costs two switches of context in each tick.
const SPIN_LOCKSTEP_NS: u64 = 300_000;
/// Longest wait for a state in real time (ns); after it the turn ends without a cycle.
// Five ticks: health is reported and late subscribers are served while physics is away.
const PATIENCE_NS: u64 = 5_000_000;

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
    let mut bell = bus.sleeper(Process::Controller(start.arm))?;
    let mut process = ControllerProcess::new(start, &bus, (cycle, planner), fifo, Monotonic)?;
    start.populate();
    cell_worker::run(&mut process, &mut bell);
    Ok(())
}

/// The loop of a modelled controller, whose planner answers at once.
///
/// # Errors
///
/// As [`run`].
pub fn model<C: Clock>(
    start: &Start,
    bus: &Bus,
    controllers: &Controllers,
    clock: C,
) -> Result<impl Turn + use<C>, ProcessError> {
    let cycle = Cycle::with(&start.cell, usize::from(start.arm), controllers)?;
    let planner = Planner::new(&start.cell, usize::from(start.arm))?;
    let planner = PlanWorker::model(planner, &cycle);
    let fifo = start.real_time(CONTROLLER_PRIORITY, 0);
    let process = ControllerProcess::new(start, bus, (cycle, planner), fifo, clock)?;
    Ok(process)
}

struct ControllerProcess<C> {
    cycle: Cycle,
    planner: PlanWorker,
    state: Subscriber<WorldState>,
    decision: Gated<Decision>,
    command: Publisher<ArmCommand>,
    status: Publisher<ArmStatus>,
    keyframes: Keyframes,
    sent: ArmCommand,
    report: ArmStatus,
    physics_bell: Doorbell,
    task_bell: Doorbell,
    health: HealthReporter,
    clock: C,
    spin_ns: u64,
    decision_limit_ticks: u64,
    awaits: Await,
    /// Generation of physics and tick that were answered last.
    answered: Option<(u32, u64)>,
    lockstep: bool,
    class: LoopClass,
    expected_ns: u64,
    /// Start of the present cycle.
    woke_ns: u64,
}

/// The message that has to arrive before the cycle continues.
#[derive(Clone, Copy)]
enum Await {
    /// A state; since the end of the last turn.
    State(Polling),
    /// In lockstep the decision for this state, until this time.
    Decision((u32, u64), u64),
    /// In lockstep the answer of the planner for this state.
    Plan((u32, u64)),
}

/// A wait for a state.
#[derive(Clone, Copy, Default)]
struct Polling {
    /// Time of the last look; `None` before the first.
    until_ns: Option<u64>,
    /// Whether lockstep has slept at its doorbell.
    has_slept: bool,
}

impl<C: Clock> Turn for ControllerProcess<C> {
    /// The cycle: take the newest inputs, update ([`Cycle::update`]), publish. All of it is one
    /// turn, unless lockstep has to wait for an input.
    fn turn(&mut self, woken: Woken) -> Wait {
        if let Await::State(polling) = self.awaits {
            if !self.take_state() {
                return self.poll_for_state(polling, woken.now_ns);
            }
            self.woke_ns = self.clock.now_ns();
            let newest = self.state.current().map(|state| &state.header);
            let newest = newest.map(|header| (header.generation, header.tick));
            // The same state may be delivered twice; a second answer would move the setpoint
            // twice.
            let Some(newest) = newest.filter(|newest| self.answered != Some(*newest)) else {
                return self.finish(true);
            };
            // Time went back: decisions about later ticks belong to a run that was set back.
            let (generation, tick) = newest;
            if self
                .answered
                .is_none_or(|(g, t)| g != generation || t > tick)
            {
                self.decision.clear();
            }
            self.awaits = Await::Decision(newest, self.woke_ns + DELIVERY_NS);
        }
        if let Await::Decision((generation, tick), until_ns) = self.awaits {
            // In lockstep that of the last tenth tick. The decision of this tick itself is kept
            // back: whether it has arrived depends on the scheduler.
            let wanted = tick.checked_sub(1).map(|t| t - t % DECISION_TICKS);
            // Before its first tick this start of physics was asked for none.
            let first = self.state.current().map_or(0, |state| state.resumed_tick);
            let wanted = wanted.filter(|wanted| *wanted >= first);
            let is_complete = self.decision.choose(generation, tick, wanted);
            if self.lockstep && !is_complete && woken.now_ns <= until_ns {
                // The wait may be as long as the launcher waits for the first sign of life.
                self.health.idle();
                self.health.publish_if_due(tick, woken.now_ns);
                return Wait::Yield;
            }
            self.awaits = Await::Plan((generation, tick));
        }
        if let Await::Plan(answering) = self.awaits {
            // In real time a late answer is taken in the cycle after its arrival.
            if !self.planner.deliver(&mut self.cycle, answering.1) && self.lockstep {
                return Wait::Yield;
            }
            self.answer(answering);
        }
        self.finish(true)
    }
}

impl<C: Clock> ControllerProcess<C> {
    fn new(
        start: &Start,
        bus: &Bus,
        (cycle, planner): (Cycle, PlanWorker),
        fifo: bool,
        clock: C,
    ) -> Result<Self, BusError> {
        let arm = start.arm;
        // Without real-time scheduling the task is late more often; a hold at each delay would
        // stop the work.
        let limit = if fifo {
            DECISION_AGE_FIFO_TICKS
        } else {
            DECISION_AGE_OTHER_TICKS
        };
        let keyframe = TopicId::Keyframe(Process::Controller(arm));
        let mut process = Self {
            cycle,
            planner,
            state: bus.subscriber(TopicId::WorldState)?,
            decision: Gated::new(bus.subscriber(TopicId::Decision)?),
            command: bus.publisher(TopicId::ArmCommand(arm))?,
            status: bus.publisher(TopicId::ArmStatus(arm))?,
            keyframes: Keyframes::new(bus.publisher(keyframe)?),
            sent: ArmCommand::zeroed(),
            report: ArmStatus::zeroed(),
            physics_bell: bus.doorbell(Process::Physics)?,
            task_bell: bus.doorbell(Process::Task)?,
            health: HealthReporter::new(
                start,
                bus,
                Process::Controller(arm),
                fifo,
                clock.now_ns(),
            )?,
            clock,
            spin_ns: if fifo { SPIN_FIFO_NS } else { SPIN_OTHER_NS },
            decision_limit_ticks: limit,
            awaits: Await::State(Polling::default()),
            answered: None,
            lockstep: false,
            class: LoopClass::new(start, CONTROLLER_PRIORITY, fifo),
            expected_ns: 0,
            woke_ns: 0,
        };
        // The state before the first command, so that a replay can start there.
        process.publish_keyframe(&Header::zeroed());
        Ok(process)
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

    /// How to wait for a state that has not arrived. Ends the turn without a cycle if it stays
    /// away.
    fn poll_for_state(&mut self, mut polling: Polling, now_ns: u64) -> Wait {
        let patience_ns = if self.lockstep {
            SPIN_LOCKSTEP_NS
        } else {
            PATIENCE_NS
        };
        let until_ns = *polling.until_ns.get_or_insert(now_ns + patience_ns);
        let wait = match self.lockstep {
            true if now_ns < until_ns => Wait::Yield,
            true if !polling.has_slept => {
                polling.has_slept = true;
                Wait::Bell
            }
            // Overdue: physics is late, starting, or not running. Polling would take its core.
            false if now_ns <= until_ns && now_ns > self.expected_ns + self.spin_ns => {
                Wait::Sleep(now_ns + self.spin_ns)
            }
            false if now_ns <= until_ns => Wait::Spin,
            _ => {
                self.woke_ns = now_ns;
                return self.finish(false);
            }
        };
        self.awaits = Await::State(polling);
        wait
    }

    /// Updates the cycle with the inputs that were taken, and publishes.
    fn answer(&mut self, (generation, tick): (u32, u64)) {
        let Some(state) = self.state.current() else {
            return;
        };
        let decision = self.decision.get(generation);
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
        if sent && self.keyframes.is_due(tick, false) {
            let of_command = self.sent.header;
            self.publish_keyframe(&of_command);
        }
    }

    /// Ends a turn, which had a cycle if `has_state`, and starts the wait for the next state.
    fn finish(&mut self, has_state: bool) -> Wait {
        // Before the first state nothing is expected, so nothing is late. In lockstep the time
        // of a state depends on all processes, so lateness means nothing.
        let late_ns = if self.lockstep || self.expected_ns == 0 {
            0
        } else {
            self.woke_ns.saturating_sub(self.expected_ns)
        };
        self.expected_ns = self.woke_ns + TICK_NS;
        let tick = self.answered.map_or(0, |(_, tick)| tick);
        let now_ns = self.clock.now_ns();
        if has_state {
            let values = self.boxed_values();
            self.health
                .cycle(tick, self.woke_ns, late_ns, values, now_ns);
        } else {
            self.health.idle();
            // A subscriber that joined late gets the newest message only by this call.
            self.command.update_connections();
            self.status.update_connections();
        }
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
        self.health.publish_if_due(tick, now_ns);
        self.awaits = Await::State(Polling::default());
        if self.lockstep {
            return Wait::Spin;
        }
        // Sleeping is not exact enough for the start of a cycle; polling all the time takes a
        // core. So it sleeps until shortly before the next state is due, then polls.
        Wait::Sleep(self.expected_ns.saturating_sub(self.spin_ns))
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

    /// Publishes a checkpoint for replay, as of the newest command, whose header is
    /// `of_command`.
    fn publish_keyframe(&mut self, of_command: &Header) {
        let (cycle, limit) = (&mut self.cycle, self.decision_limit_ticks);
        let save = |bytes: &mut [u8]| cycle.save(limit, bytes).ok();
        let after_seq = self.command.seq();
        if !self.keyframes.send_whole(of_command, after_seq, save) {
            self.health
                .note("the controller's checkpoint could not be kept: no replay verifies this run");
        }
    }
}
