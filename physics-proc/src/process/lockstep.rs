//! Lockstep: a tick when all processes have answered the one before (ADR 0004).

use std::time::Duration;

use cell_bus::Doorbell;
use cell_model::runs::spec::Speed;
use cell_rt::signal::stop_requested;
use cell_rt::{Grid, monotonic_ns};
use ipc_types::topic::Process;
use ipc_types::{DECISION_TICKS, Header, TICK_NS};

use super::PhysicsProcess;
use crate::plant::Next;

/// How long lockstep polls before it sleeps (ns): longer than a cycle of a controller.
// Sleeping costs two switches of context per tick; an answer normally arrives within this
// time.
const SPIN_NS: u64 = 200_000;
/// Interval at which a waiting physics repeats its doorbells and its status.
// Many ticks, so a waiting physics costs no core, and far below the 100 ms of a process
// without a sign of life.
const NUDGE: Duration = Duration::from_millis(5);

impl PhysicsProcess {
    /// A tick when all processes have answered the one before, at most one in
    /// `period_ns`.
    pub(super) fn lockstep(&mut self, speed: Speed, period_ns: u64) {
        let mut grid = Grid::new(period_ns.max(1), monotonic_ns(), false);
        self.publish();
        while !stop_requested() && self.plant.speed() == speed {
            let began_ns = monotonic_ns();
            if !self.wait_for_answers() {
                break;
            }
            // Before the step: after it the newest saved state would be too old already.
            self.resume.wait(self.tick);
            if period_ns > 0 {
                grid.wait();
            }
            let next = self.step();
            if next == Next::Wait {
                // Paused: the same tick is published again, at an interval that costs nothing.
                self.sleeper.wait(NUDGE);
                self.health.idle();
            }
            self.publish();
            self.keep();
            if next != Next::Wait {
                self.health.cycle(self.tick, began_ns, 0, self.boxed);
            }
            self.health.publish_if_due(self.tick, monotonic_ns());
        }
    }

    /// Waits until every controller has answered this tick and, on every tenth,
    /// the task. `false` when asked to stop.
    fn wait_for_answers(&mut self) -> bool {
        let mut patient_until_ns = monotonic_ns() + SPIN_NS;
        loop {
            self.take_inputs();
            self.recorder.refresh();
            match self.missing() {
                None => {
                    self.health.note("");
                    return true;
                }
                // A run that has ended waits for no answer, but continues to serve requests
                // until the launcher stops it.
                Some(_) if self.plant.is_ending() => return true,
                Some(_) if monotonic_ns() < patient_until_ns => std::thread::yield_now(),
                Some(process) => {
                    if stop_requested() {
                        return false;
                    }
                    // Woken by a doorbell: take the inputs at once, without the report below.
                    if self.sleeper.wait(NUDGE) {
                        continue;
                    }
                    self.health.idle();
                    // Only the recorder has a limit of patience: a run without its controller
                    // or task cannot continue, one without its recording can.
                    if process == Process::Monitor {
                        self.recorder.waited(monotonic_ns());
                    }
                    self.health
                        .note(&format!("tick {} waits for {}", self.tick, process.name()));
                    self.health.publish_if_due(self.tick, monotonic_ns());
                    // A process that was started again subscribes during this wait and needs
                    // this state to answer.
                    self.state.update_connections();
                    self.tap.update_connections();
                    self.ring_all();
                    patient_until_ns = monotonic_ns() + SPIN_NS;
                }
            }
        }
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
