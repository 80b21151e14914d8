//! A process: its loop, and when its next turn is.

use std::time::Duration;

use cell_bus::{Bus, Kept, Sleeper};
use cell_rt::process::Share;
use cell_worker::{Start, Turn, Wait, Woken};
use ipc_types::topic::Process;

use super::Model;
use super::monitor::Monitor;
use crate::plan::MS;

/// How late a loop that polls sees what another process did (ns).
const POLL_NS: u64 = 5_000;
/// Longest time between two looks of a loop that polls (ns).
// It looks as soon as another process had an effect. What depends on the time alone, such as the
// end of its patience, takes milliseconds.
const IDLE_POLL_NS: u64 = 200_000;
/// Longest sleep at a doorbell (ns), as in `cell_worker::run`.
const NUDGE_NS: u64 = 5 * MS;

/// What a process waits for.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Waits {
    /// A time.
    Time,
    /// An effect of another, for which it polls.
    Effect,
    /// Its doorbell.
    Bell,
}

/// A process that exists.
pub(super) struct Running {
    pub(super) process: Process,
    pub(super) generation: u32,
    pub(super) pid: u32,
    /// `None` until it has started.
    pub(super) turns: Option<Box<dyn Turn>>,
    sleeper: Option<Sleeper>,
    /// When its next turn is, if it gets a core.
    next_ns: u64,
    waits: Waits,
    by_bell: bool,
    pub(super) frozen_until_ns: u64,
    pub(super) starved_until_ns: u64,
    /// Since when it works on one turn.
    pub(super) hangs_since_ns: Option<u64>,
    /// Least time of a turn, and until when (ns).
    pub(super) slow: (u64, u64),
    /// For how long it loses its core within a turn, and until when (ns).
    pub(super) preempted: (u64, u64),
    /// The rest of a turn within which it lost its core, and when it gets one.
    kept: (Vec<Kept>, u64),
    pub(super) is_stopping: bool,
    /// It is killed after so many effects of its next turn.
    pub(super) cut: Option<u64>,
    ran_ns: u64,
    waited_ns: u64,
}

impl Running {
    /// Of start number `generation`, whose loop begins at `begins_ns`.
    pub(super) fn new(process: Process, generation: u32, pid: u32, begins_ns: u64) -> Self {
        Self {
            process,
            generation,
            pid,
            turns: None,
            sleeper: None,
            next_ns: begins_ns,
            waits: Waits::Time,
            by_bell: false,
            frozen_until_ns: 0,
            starved_until_ns: 0,
            hangs_since_ns: None,
            slow: (0, 0),
            preempted: (0, 0),
            kept: (Vec::new(), 0),
            is_stopping: false,
            cut: None,
            ran_ns: 0,
            waited_ns: 0,
        }
    }

    /// When it gets a core for its next turn.
    pub(super) fn due_ns(&self) -> u64 {
        if self.hangs_since_ns.is_some() {
            return u64::MAX;
        }
        let (kept, kept_ns) = &self.kept;
        let next_ns = if kept.is_empty() {
            self.next_ns
        } else {
            *kept_ns
        };
        next_ns.max(self.starved_until_ns).max(self.frozen_until_ns)
    }

    /// It lost its core within its turn, and continues at `at_ns` with what is `kept`.
    pub(super) fn keep(&mut self, kept: Vec<Kept>, at_ns: u64) {
        if !kept.is_empty() {
            self.next_ns = self.next_ns.max(at_ns + POLL_NS);
            self.kept = (kept, at_ns);
        }
    }

    /// What is left of its turn; empty if that ended.
    pub(super) fn take_kept(&mut self) -> Vec<Kept> {
        std::mem::take(&mut self.kept.0)
    }

    /// It has waited for a core from the time it could run until `now_ns`.
    pub(super) fn waited(&mut self, now_ns: u64) {
        if self.starved_until_ns > self.next_ns {
            self.waited_ns += now_ns.min(self.starved_until_ns) - self.next_ns;
        }
    }

    pub(super) fn begin(&mut self, turns: Box<dyn Turn>, sleeper: Sleeper, now_ns: u64) {
        (self.turns, self.sleeper) = (Some(turns), Some(sleeper));
        self.next_ns = now_ns;
    }

    /// How long its turn takes (ns) if it has a core; `percent` is drawn.
    pub(super) fn cost_ns(&self, percent: u64) -> u64 {
        let least = match self.process {
            Process::Physics => 100_000,
            Process::Controller(_) => 30_000,
            Process::Task => 150_000,
            Process::Monitor => 50_000,
        };
        least + least * percent / 100
    }

    /// One turn of its loop at `now_ns`, which takes `cost_ns` if it `worked` and did not only
    /// poll; returns whether it did.
    pub(super) fn turn(
        &mut self,
        now_ns: u64,
        jitter_ns: u64,
        cost_ns: u64,
        worked: impl Fn() -> bool,
    ) -> bool {
        let Some(turns) = &mut self.turns else {
            return false;
        };
        let by_bell = std::mem::take(&mut self.by_bell);
        let wait = turns.turn(Woken { now_ns, by_bell });
        let has_worked = worked();
        let ran_ns = if has_worked { cost_ns } else { POLL_NS };
        // On a busy core it waits for the others during its turn.
        let (slow_ns, until_ns) = self.slow;
        let is_slow = has_worked && now_ns < until_ns;
        let waited_ns = if is_slow {
            slow_ns.saturating_sub(ran_ns)
        } else {
            0
        };
        let end_ns = now_ns + ran_ns + waited_ns;
        self.waits = match wait {
            Wait::Bell => Waits::Bell,
            Wait::Spin | Wait::Yield if !has_worked => Waits::Effect,
            _ => Waits::Time,
        };
        self.next_ns = match wait {
            Wait::Deadline { at_ns, .. } => end_ns.max(at_ns + jitter_ns),
            Wait::Sleep(until_ns) => end_ns.max(until_ns + jitter_ns),
            Wait::Spin | Wait::Yield if has_worked => end_ns,
            Wait::Spin | Wait::Yield => now_ns + IDLE_POLL_NS,
            Wait::Bell => end_ns + NUDGE_NS,
        };
        self.ran_ns += ran_ns;
        self.waited_ns += waited_ns;
        has_worked
    }

    /// Another process had an effect at `now_ns`: one that polls sees it soon, and one at its
    /// doorbell after `latency_ns` if that rang.
    pub(super) fn notice(&mut self, now_ns: u64, latency_ns: impl FnOnce() -> u64) {
        if self.waits == Waits::Effect {
            self.next_ns = self.next_ns.min(now_ns + POLL_NS);
        }
        let rang = |sleeper: &mut Sleeper| sleeper.wait(Duration::ZERO);
        if self.waits == Waits::Bell && self.sleeper.as_mut().is_some_and(rang) {
            (self.waits, self.by_bell) = (Waits::Time, true);
            self.next_ns = self.next_ns.min(now_ns + latency_ns());
        }
    }

    /// What the kernel says of its main thread at `now_ns`.
    pub(super) fn share(&self, now_ns: u64) -> Share {
        if let Some(since_ns) = self.hangs_since_ns {
            return Share {
                ran_ns: self.ran_ns + now_ns.saturating_sub(since_ns),
                waited_ns: self.waited_ns,
                waits: false,
                sleeps: false,
                ended: false,
            };
        }
        let can_run = self.next_ns <= now_ns;
        let is_frozen = now_ns < self.frozen_until_ns;
        let waits = can_run && !is_frozen && now_ns < self.starved_until_ns;
        let waiting_ns = if waits { now_ns - self.next_ns } else { 0 };
        Share {
            ran_ns: self.ran_ns,
            waited_ns: self.waited_ns + waiting_ns,
            waits,
            sleeps: !can_run && !is_frozen,
            ended: false,
        }
    }
}

impl Model {
    /// The loop of start number `generation` of `process`, with its doorbell.
    pub(super) fn set_up(
        &self,
        process: Process,
        generation: u32,
    ) -> Result<(Box<dyn Turn>, Sleeper), String> {
        let bus = self.bus(generation);
        let turns = self.turns_of(process, generation, &bus)?;
        let sleeper = bus.sleeper(process).map_err(|error| error.to_string())?;
        Ok((turns, sleeper))
    }

    fn turns_of(
        &self,
        process: Process,
        generation: u32,
        bus: &Bus,
    ) -> Result<Box<dyn Turn>, String> {
        let arm = match process {
            Process::Controller(arm) => arm,
            _ => 0,
        };
        let start = Start::modelled(self.spec.clone(), self.cell.clone(), generation, arm);
        let clock = self.site.clone();
        Ok(match process {
            Process::Physics => {
                let store = self.disk.store(&self.site);
                let clock = (clock, self.plan.is_ideal());
                let model = physics_proc::process::model(&start, bus, store, &self.requests, clock);
                Box::new(model.map_err(|error| error.to_string())?)
            }
            Process::Controller(_) => {
                let model = controller_proc::process::model(&start, bus, &self.controllers, clock);
                Box::new(model.map_err(|error| error.to_string())?)
            }
            Process::Task => {
                let (policies, files) = (&self.policies, &self.task_files);
                let model =
                    robocell_task_program::process::model(&start, bus, policies, files, clock);
                Box::new(model.map_err(|error| error.to_string())?)
            }
            Process::Monitor => {
                let monitor = Monitor::new(&start, bus, clock);
                Box::new(monitor.map_err(|error| error.to_string())?)
            }
        })
    }
}
