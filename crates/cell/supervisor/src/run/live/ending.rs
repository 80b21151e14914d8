//! The end of a run: by the task, by a standstill, on request or by a failure.

use cell_rt::clock::monotonic_ns;
use ipc_types::decision::Outcome;
use ipc_types::operator::OperatorAction;
use ipc_types::topic::Process;
use ipc_types::world::{FLAG_ENDING, FLAG_LOCKSTEP, FLAG_PAUSED};

use super::{End, LiveCell};
use crate::failure::Failure;
use crate::supervision::Event;

impl LiveCell {
    /// The first end counts; then everything stops in order.
    pub(super) fn finish_with(&mut self, mut end: End) {
        if self.end.is_none() {
            if let End::Stopped(summary) = &mut end {
                *summary = self.summary().map(Box::new);
            }
            self.end = Some(end);
            self.planning.close();
            self.supervisor
                .handle(monotonic_ns(), Event::Stop, &mut Vec::new());
        }
    }

    pub(super) fn look_for_the_end(&mut self) {
        if self.end.is_some() {
            return;
        }
        self.look_for_a_standstill();
        let Some(state) = self.watch.state() else {
            return;
        };
        let gives_start = self.plan.spec.until_done || self.plan.loops;
        if state.has(FLAG_ENDING) {
            if let Some(summary) = self.summary() {
                self.finish_with(End::Finished(Box::new(summary)));
            }
        } else if gives_start && !self.start_event_given && self.supervisor.is_ready() {
            self.give_start_event();
        }
    }

    /// In lockstep all processes wait for each other: one that lives but never
    /// answers is named, and the run fails.
    fn look_for_a_standstill(&mut self) {
        let Some(state) = self.watch.state() else {
            return;
        };
        self.supervisor.set_lockstep(state.has(FLAG_LOCKSTEP));
        let excused = state.has(FLAG_PAUSED) || state.has(FLAG_ENDING) || state.script_line > 0;
        let waits = state.has(FLAG_LOCKSTEP) && !excused && self.supervisor.is_ready();
        let (tick, now_ns) = (state.header.tick, monotonic_ns());
        if self.standstill.lasts(tick, waits, now_ns) {
            let health = self.watch.health(Process::Physics);
            let note = health.map_or("", |health| health.note.as_str());
            let message = format!("the cell makes no progress: {note}; `robocell logs` says more");
            self.finish_with(End::GaveUp(Failure::gave_up(message)));
        }
    }

    /// `--until-done` starts a task that waits to be started.
    fn give_start_event(&mut self) {
        let Some(decision) = self.watch.decision() else {
            return;
        };
        if decision.outcome == Outcome::Idle.code() {
            self.bus.ask(OperatorAction::TaskStart, 0);
        } else {
            self.start_event_given = true;
        }
    }
}
