//! A number of kills at random instants of a whole job: what `--kills` does.
//!
//! The first job runs without a kill. It measures the length of the job, and how many
//! parts are in place at its end. The kills are spread over jobs of this length. An
//! instant at which no kill is possible (a process is not back yet, or the kill before was
//! a moment ago) is tried again in the next job, so that early and late parts of the job
//! are hit alike, however fast it is.

#[cfg(test)]
mod tests;

use std::collections::VecDeque;

use ipc_types::topic::Process;
use schemars::JsonSchema;
use serde::Serialize;

use super::fault::Struck;
use cell_model::random::Random;

/// From one process's return to the next kill (ns): the supervisor gives up a process that
/// ends six times within 10 s.
const SPACING_NS: u64 = 2_500_000_000;
/// A process that is not back after this is given up (ns).
const PATIENCE_NS: u64 = 30_000_000_000;
/// A successor of physics that resumes from further back breaks a promise (ticks).
pub(super) const MOST_TICKS_LOST: u64 = 1000;
/// Jobs in a row that ended without a kill: they are too short to be hit.
const BARREN_JOBS: u32 = 3;

/// One kill, and what the process's successor resumed from.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
pub(crate) struct Kill {
    /// Number of the job, from 1; the first job has none.
    pub(super) job: u64,
    /// Seed of the job.
    pub(super) seed: u64,
    /// What was killed.
    pub(super) process: String,
    /// Newest tick before the kill.
    pub(super) tick: u64,
    /// From this tick back to the one that physics resumed from; null for other processes,
    /// and where physics did not come back.
    pub(super) ticks_lost: Option<u64>,
    /// Until the successor's first state, decision or health message (ms); null where none
    /// was seen within 30 s.
    pub(super) back_ms: Option<f64>,
}

impl Kill {
    /// Whether it cost more than is promised.
    pub(super) fn is_bad(&self) -> bool {
        self.back_ms.is_none() || self.ticks_lost.is_some_and(|lost| lost > MOST_TICKS_LOST)
    }
}

/// State of the cell at one moment.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sight {
    /// Every process works, and the job is not over.
    pub(super) can_be_hit: bool,
    /// Of the newest state.
    pub(super) tick: u64,
    /// Start of physics that published it.
    pub(super) generation: u32,
    /// Tick which that start of physics began with.
    pub(super) resumed_tick: u64,
}

/// A kill whose successor was not seen yet.
#[derive(Clone, Debug)]
struct Pending {
    struck: Struck,
    instant: f64,
    tick: u64,
}

/// The kills of a series of jobs.
#[derive(Debug)]
pub(super) struct Kills {
    random: Random,
    /// Instants of kills, as shares of the job, in order.
    left: VecDeque<f64>,
    /// Instants for the next job.
    postponed: Vec<f64>,
    /// Ticks of the job without a kill.
    length: Option<u64>,
    pending: Option<Pending>,
    next_ns: u64,
    /// Number and seed of the job.
    job: (u64, u64),
    done: Vec<Kill>,
    /// Kills when the job began.
    done_before: usize,
    barren_jobs: u32,
}

impl Kills {
    /// So many, at instants that follow from `seed`.
    pub(super) fn new(count: u32, seed: u64) -> Self {
        let mut random = Random::new(seed);
        let postponed = (0..count).map(|_| random.share()).collect();
        Self {
            random,
            left: VecDeque::new(),
            postponed,
            length: None,
            pending: None,
            next_ns: 0,
            job: (0, 0),
            done: Vec::new(),
            done_before: 0,
            barren_jobs: 0,
        }
    }

    /// Starts job number `job`.
    pub(super) fn begin_job(&mut self, job: u64, seed: u64) {
        self.job = (job, seed);
        self.done_before = self.done.len();
        // `turn` compares only the first instant with the time.
        self.postponed.sort_by(f64::total_cmp);
        self.left = self.postponed.drain(..).collect();
        // Each job has its own supervisor, whose count of crashes starts at 0.
        self.next_ns = 0;
    }

    /// One look at `now_ns`. `strike` kills a process; `works` names the newest start of a
    /// process of which work was seen.
    pub(super) fn turn(
        &mut self,
        now_ns: u64,
        sight: &Sight,
        strike: impl FnOnce(&mut Random) -> Option<Struck>,
        works: impl Fn(Process) -> u32,
    ) {
        self.note_return(now_ns, sight, works);
        let Some(length) = self.length.filter(|_| sight.can_be_hit) else {
            return;
        };
        let is_due = |instant: &f64| *instant * length as f64 <= sight.tick as f64;
        let Some(instant) = self.left.front().copied().filter(is_due) else {
            return;
        };
        // Removed even if no kill is possible now: later in this job it would not be the instant
        // drawn.
        self.left.pop_front();
        let may_strike = self.pending.is_none() && now_ns >= self.next_ns;
        let struck = may_strike.then(|| strike(&mut self.random)).flatten();
        match struck {
            Some(struck) => {
                self.pending = Some(Pending {
                    struck,
                    instant,
                    tick: sight.tick,
                });
            }
            None => self.postponed.push(instant),
        }
    }

    fn note_return(&mut self, now_ns: u64, sight: &Sight, works: impl Fn(Process) -> u32) {
        let Some(pending) = &mut self.pending else {
            return;
        };
        let Struck {
            process,
            generation,
            since_ns,
        } = pending.struck;
        // The last states of a process that is gone may be heard after its end.
        if process == Process::Physics && sight.generation <= generation {
            pending.tick = pending.tick.max(sight.tick);
        }
        let took_ns = now_ns.saturating_sub(since_ns);
        let is_back = works(process) > generation;
        if !is_back && took_ns < PATIENCE_NS {
            return;
        }
        let is_physics = is_back && process == Process::Physics;
        self.done.push(Kill {
            job: self.job.0,
            seed: self.job.1,
            process: process.name(),
            tick: pending.tick,
            ticks_lost: is_physics.then(|| pending.tick.saturating_sub(sight.resumed_tick)),
            back_ms: is_back.then_some(took_ns as f64 * 1.0e-6),
        });
        self.pending = None;
        self.next_ns = now_ns + SPACING_NS;
    }

    /// The job ended; `ticks` is its length where it was done.
    pub(super) fn end_of_job(&mut self, ticks: Option<u64>) {
        if self.length.is_none() {
            // The job that is measured.
            self.length = ticks;
            self.postponed.extend(self.left.drain(..));
            return;
        }
        // The job ended before the successor was seen: this kill proves nothing and is repeated.
        let killed_last = self.pending.take();
        self.postponed.extend(killed_last.map(|kill| kill.instant));
        // This job was shorter than the first one: it is hit at other instants.
        let not_reached = std::mem::take(&mut self.left);
        let again = not_reached.iter().map(|_| self.random.share());
        self.postponed.extend(again);
        let is_barren = self.done.len() == self.done_before;
        self.barren_jobs = if is_barren { self.barren_jobs + 1 } else { 0 };
    }

    /// Why another job is of no use, if it is.
    pub(super) fn is_over(&self) -> bool {
        let is_measured = self.length.is_some() || self.job.0 == 0;
        let has_left = !self.postponed.is_empty();
        !is_measured || !has_left || self.barren_jobs >= BARREN_JOBS
    }

    /// Why there is no other job, where kills are missing; `stopped`: a person ended the
    /// series.
    pub(super) fn why_over(&self, stopped: bool) -> &'static str {
        if stopped {
            "the series was stopped"
        } else if self.length.is_none() {
            "the job without a kill did not end as done"
        } else {
            "jobs end before their processes work"
        }
    }

    /// Kills that were not done.
    pub(super) fn missing(&self) -> usize {
        self.postponed.len() + self.left.len() + usize::from(self.pending.is_some())
    }

    /// The kills so far.
    pub(super) fn into_done(self) -> Vec<Kill> {
        self.done
    }
}
