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

use cell_bus::{Bus, BusError};
use cell_model::stop::{DECISION_AGE_FIFO_TICKS, DECISION_AGE_OTHER_TICKS};
use cell_rt::priority::CONTROLLER_PRIORITY;
use cell_rt::{Clock, Monotonic};
use cell_worker::{ArmLoop, DELIVERY_NS, Ended, Gated, RunError, Start, Turn, Wait, Woken};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{DECISION_TICKS, Decision};

use crate::controllers::Controllers;
use crate::cycle::Cycle;
use crate::planning::Planner;
use crate::planning::worker::PlanWorker;
use crate::rmpflow_controller::RmpFlowError;

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
    arm: ArmLoop<C>,
    decision: Gated<Decision>,
    decision_limit_ticks: u64,
    awaits: Await,
    /// Generation of physics and tick that were answered last.
    answered: Option<(u32, u64)>,
}

/// The message that has to arrive before the cycle continues.
#[derive(Clone, Copy)]
enum Await {
    /// A state.
    State,
    /// In lockstep the decision for this state, until this time.
    Decision((u32, u64), u64),
    /// In lockstep the answer of the planner for this state.
    Plan((u32, u64)),
}

impl<C: Clock> Turn for ControllerProcess<C> {
    /// The cycle: take the newest inputs, update ([`Cycle::update`]), publish. All of it is one
    /// turn, unless lockstep has to wait for an input.
    fn turn(&mut self, woken: Woken) -> Wait {
        if let Await::State = self.awaits {
            if !self.arm.take_state() {
                let wait = self.arm.poll(woken.now_ns);
                return wait.unwrap_or_else(|| self.finish(false));
            }
            self.arm.begin();
            // The same state may be delivered twice; a second answer would move the setpoint
            // twice.
            let newest = self.arm.newest();
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
            self.awaits = Await::Decision(newest, self.arm.woke_ns() + DELIVERY_NS);
        }
        if let Await::Decision((generation, tick), until_ns) = self.awaits {
            // In lockstep that of the last tenth tick. The decision of this tick itself is kept
            // back: whether it has arrived depends on the scheduler.
            let wanted = tick.checked_sub(1).map(|t| t - t % DECISION_TICKS);
            // Before its first tick this start of physics was asked for none.
            let first = self.arm.state().map_or(0, |state| state.resumed_tick);
            let wanted = wanted.filter(|wanted| *wanted >= first);
            let is_complete = self.decision.choose(generation, tick, wanted);
            if self.arm.is_lockstep() && !is_complete && woken.now_ns <= until_ns {
                // The wait may be as long as the launcher waits for the first sign of life.
                self.arm.health.idle();
                self.arm.health.publish_if_due(tick, woken.now_ns);
                return Wait::Yield;
            }
            self.awaits = Await::Plan((generation, tick));
        }
        if let Await::Plan(answering) = self.awaits {
            // In real time a late answer is taken in the cycle after its arrival.
            let is_delivered = self.planner.deliver(&mut self.cycle, answering.1);
            if !is_delivered && self.arm.is_lockstep() {
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
        (mut cycle, planner): (Cycle, PlanWorker),
        fifo: bool,
        clock: C,
    ) -> Result<Self, BusError> {
        // Without real-time scheduling the task is late more often; a hold at each delay would
        // stop the work.
        let limit = if fifo {
            DECISION_AGE_FIFO_TICKS
        } else {
            DECISION_AGE_OTHER_TICKS
        };
        let mut arm = ArmLoop::new(start, bus, fifo, clock)?;
        arm.keep_first(|bytes| cycle.save(limit, bytes).ok());
        Ok(Self {
            cycle,
            planner,
            arm,
            decision: Gated::new(bus.subscriber(TopicId::Decision)?),
            decision_limit_ticks: limit,
            awaits: Await::State,
            answered: None,
        })
    }

    /// Updates the cycle with the inputs that were taken, and publishes.
    fn answer(&mut self, (generation, tick): (u32, u64)) {
        let (cycle, arm, limit) = (&mut self.cycle, &mut self.arm, self.decision_limit_ticks);
        let decision = self.decision.get(generation);
        let (state, command, report) = arm.cycle();
        let Some(state) = state else {
            return;
        };
        cycle.update(state, decision, limit, command, report);
        // After the update, which made the request: the planner has all of the interval for
        // it.
        self.planner.hand_over(cycle);
        let is_sent = arm.publish();
        self.answered = Some((generation, tick));
        // A command that was not sent has no sequence number for the checkpoint to follow.
        if is_sent {
            arm.keep_if_due(tick, |bytes| cycle.save(limit, bytes).ok());
        }
    }

    /// Ends a turn, which had a cycle if `has_cycle`, and starts the wait for the next state.
    fn finish(&mut self, has_cycle: bool) -> Wait {
        let counts = self.decision.counts();
        let invalid = self.decision.take_invalid();
        self.arm.refused("decision", invalid);
        self.awaits = Await::State;
        let ended = Ended {
            has_cycle,
            tick: self.answered.map_or(0, |(_, tick)| tick),
            values: self.boxed_values(),
            missed: self.arm.report.missed_cycles,
            refused: (counts.rejected, counts.fenced),
        };
        self.arm.finish(&ended)
    }

    /// Values of a cycle that the black box keeps for an incident.
    fn boxed_values(&self) -> [f64; 4] {
        let (speeds, report) = (self.arm.sent.joint_velocities, &self.arm.report);
        [
            f64::from(report.stop_action),
            report.decision_age_ticks as f64,
            speeds
                .iter()
                .fold(0.0, |top: f64, speed| top.max(speed.abs())),
            report.position_error,
        ]
    }
}
