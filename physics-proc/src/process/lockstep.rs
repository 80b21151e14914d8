//! Lockstep: a tick when all processes have answered the one before (ADR 0004).

use cell_bus::Doorbell;
use cell_rt::Clock;
use cell_run::spec::Speed;
use cell_worker::{Wait, Woken};
use ipc_types::topic::Process;
use ipc_types::{DECISION_TICKS, Header, TICK_NS};

use super::{Await, PhysicsProcess};
use crate::plant::Next;
use crate::resume::Store;

/// How long lockstep polls before it sleeps (ns): longer than a cycle of a controller.
// Sleeping costs two switches of context per tick; an answer normally arrives within this
// time.
const SPIN_NS: u64 = 200_000;

/// A wait for the answers to a tick.
#[derive(Clone, Copy)]
pub(super) struct Answers {
    began_ns: u64,
    /// When it sleeps.
    patient_until_ns: u64,
    /// The process whose answer was missing before it slept.
    slept_for: Option<Process>,
    /// Requests were answered that no state shows yet.
    has_news: bool,
}

impl Answers {
    pub(super) fn since(now_ns: u64) -> Self {
        Self {
            began_ns: now_ns,
            patient_until_ns: now_ns + SPIN_NS,
            slept_for: None,
            has_news: false,
        }
    }
}

impl<C: Clock, S: Store> PhysicsProcess<C, S> {
    /// Makes the next tick, at most one in a period, if every controller has answered this one
    /// and, on every tenth, the task.
    pub(super) fn answers(&mut self, mut answers: Answers, woken: Woken) -> Wait {
        // Woken by a doorbell: take the inputs at once, without the report.
        if let Some(process) = answers.slept_for.take()
            && !woken.by_bell
        {
            self.report_wait(process);
            answers.patient_until_ns = self.clock.now_ns() + SPIN_NS;
        }
        answers.has_news |= self.take_inputs();
        self.recorder.refresh();
        match self.missing() {
            None => self.health.note(""),
            // A run that has ended waits for no answer, but continues to serve requests
            // until the launcher stops it.
            Some(_) if self.plant.is_ending() => {}
            Some(_) if woken.now_ns < answers.patient_until_ns => {
                self.awaits = Await::Answers(answers);
                return Wait::Yield;
            }
            missing => {
                // A reset shows although time does not pass: a client of an arm starts from it.
                if std::mem::take(&mut answers.has_news) {
                    self.publish();
                    // It may be announced as saved: the next tick is another state.
                    self.keep();
                }
                answers.slept_for = missing;
                self.awaits = Await::Answers(answers);
                return Wait::Bell;
            }
        }
        // Before the step: after it the newest saved state would be too old already.
        self.resume.wait(self.tick);
        if matches!(self.speed, Some(Speed::Factor(_))) {
            self.awaits = Await::Pace(answers.began_ns);
            return Wait::next_of(&mut self.grid, self.clock.now_ns());
        }
        self.lockstep(answers.began_ns)
    }

    /// For people, and for a process that may have missed the present tick.
    fn report_wait(&mut self, missing: Process) {
        self.health.idle();
        // Only the recorder has a limit of patience: a run without its controller
        // or task cannot continue, one without its recording can.
        if missing == Process::Monitor {
            self.recorder.waited(self.clock.now_ns());
        }
        self.health
            .note(&format!("tick {} waits for {}", self.tick, missing.name()));
        self.health.publish_if_due(self.tick, self.clock.now_ns());
        // A process that was started again subscribes during this wait and needs
        // this state to answer.
        self.state.update_connections();
        self.tap.update_connections();
        self.ring_all();
    }

    /// A tick that all processes have answered.
    pub(super) fn lockstep(&mut self, began_ns: u64) -> Wait {
        let next = self.step();
        if next == Next::Wait {
            // Paused: the same tick is published again, at an interval that costs nothing.
            self.awaits = Await::Request(began_ns);
            return Wait::Bell;
        }
        self.finish_lockstep(began_ns, next)
    }

    /// Publishes the state after a turn that stepped or, paused, did not.
    pub(super) fn finish_lockstep(&mut self, began_ns: u64, next: Next) -> Wait {
        self.publish();
        self.keep();
        let now_ns = self.clock.now_ns();
        if next != Next::Wait {
            self.health
                .cycle(self.tick, began_ns, 0, self.boxed, now_ns);
        }
        self.health.publish_if_due(self.tick, now_ns);
        self.next()
    }

    fn ring_all(&mut self) {
        self.controller_bells.iter_mut().for_each(Doorbell::ring);
        self.task_bell.ring();
    }

    /// The first process whose answer to this tick is missing.
    fn missing(&self) -> Option<Process> {
        let answered =
            |header: &Header| header.tick >= self.tick && header.answers(self.generation);
        for (arm, command) in (0_u8..).zip(&self.commands) {
            if !command.get().is_some_and(|c| answered(&c.header)) {
                return Some(Process::Controller(arm));
            }
        }
        let due = self.tick.is_multiple_of(DECISION_TICKS);
        if due && !self.decision.get().is_some_and(|d| answered(&d.header)) {
            return Some(Process::Task);
        }
        let behind = self.recorder.is_behind(self.generation, self.tick);
        behind.then_some(Process::Monitor)
    }
}

/// Period of a tick at `factor` times real time (ns).
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the factor was checked to be between 0.01 and 50"
)]
pub(super) fn paced_period_ns(factor: f64) -> u64 {
    (TICK_NS as f64 / factor) as u64
}
