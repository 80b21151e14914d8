//! The end of a run: by the task, by a standstill, on request or by a failure.

use ipc_types::decision::Outcome;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;
use ipc_types::world::{FLAG_ENDING, FLAG_LOCKSTEP, FLAG_PAUSED};

use super::SupervisorLoop;
use crate::failure::Failure;
use crate::run::machine::Machine;
use crate::supervision::Event;

/// How a run ended without a request.
#[derive(Clone, Debug)]
pub enum Verdict {
    /// With the task, or at its time limit.
    Finished,
    /// Because a process could not be kept running, or refused the cell.
    GaveUp(Failure),
}

impl<M: Machine> SupervisorLoop<M> {
    /// Stops every process in order. The run has ended on request.
    pub fn end(&mut self, now: u64) {
        self.is_ending = true;
        self.supervisor.handle(now, Event::Stop, &mut Vec::new());
    }

    /// How the run ended without a request, once.
    pub fn take_verdict(&mut self) -> Option<Verdict> {
        self.verdict.take()
    }

    /// The first end counts; then every process is stopped in order.
    pub(super) fn conclude(&mut self, now: u64, verdict: Verdict) {
        if !self.is_ending {
            self.verdict = Some(verdict);
            self.end(now);
        }
    }

    pub(super) fn look_for_the_end(&mut self, now: u64) {
        if self.is_ending {
            return;
        }
        self.look_for_a_standstill(now);
        let Some(state) = self.watch.state() else {
            return;
        };
        if state.has(FLAG_ENDING) {
            self.conclude(now, Verdict::Finished);
        } else if self.terms.gives_start && !self.start_event_given && self.supervisor.is_ready() {
            self.give_start_event();
        }
    }

    /// In lockstep all processes wait for each other: one that lives but never
    /// answers is named, and the run fails.
    fn look_for_a_standstill(&mut self, now: u64) {
        let Some(state) = self.watch.state() else {
            return;
        };
        // In each turn, as a person can change the speed of a running cell.
        self.supervisor.set_lockstep(state.has(FLAG_LOCKSTEP));
        // Physics waits on purpose: for a person, for the launcher, or for a program of a client.
        let mut excused = state.has(FLAG_PAUSED) || state.has(FLAG_ENDING) || state.script_line > 0;
        excused |= self.terms.has_clients;
        let waits = state.has(FLAG_LOCKSTEP) && !excused && self.supervisor.is_ready();
        if self.standstill.lasts(state.header.tick, waits, now) {
            let health = self.watch.health(Process::Physics);
            let note = health.map_or("", |health| health.note.as_str());
            let message = format!("the cell makes no progress: {note}; `robocell logs` says more");
            self.conclude(now, Verdict::GaveUp(Failure::gave_up(message)));
        }
    }

    /// `--until-done` starts a task that waits to be started.
    fn give_start_event(&mut self) {
        let Some(decision) = self.watch.decision() else {
            return;
        };
        if decision.outcome == Outcome::Idle.code() {
            // Repeated until it has an effect: a request may be dropped or remain unanswered.
            self.machine.ask(OperatorAction::TaskStart, 0);
        } else {
            self.start_event_given = true;
        }
    }
}
