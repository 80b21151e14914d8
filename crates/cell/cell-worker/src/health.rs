//! The health of this process, published at 100 Hz.
//!
//! The launcher takes a message that does not arrive for a sign of a hang and kills the
//! process. So every loop of a process, also one that waits, has to reach `publish_if_due`; and
//! a full disk, a missing ring or a failed send must not end the process that reports them.

use cell_bus::{Bus, BusError, Publisher};
use cell_rt::black_box::VALUES;
use cell_rt::overrun::OverrunWatch;
use cell_rt::{BlackBox, BoxedCycle, Histogram};
use cell_run::incident::ring_path;
use ipc_types::health::{FAULT, NOTE_BYTES, Scheduling};
use ipc_types::topic::{Process, TopicId};
use ipc_types::{DECISION_TICKS, Header, Health, Invalid, TICK_NS, Text};

use crate::Start;

/// Period of the message (ns).
// Ten messages within the shortest hang limit of the launcher (100 ms).
const PERIOD_NS: u64 = 10_000_000;
/// Length of the window over which the figures are computed (ns).
// A second holds 1,000 cycles of a loop, the least that gives a p99 of ten values.
const WINDOW_NS: u64 = 1_000_000_000;

/// Time for which a refused message is reported (ns).
// One message among thousands would otherwise be gone from `status` before a person looks.
const REFUSED_NS: u64 = 5_000_000_000;

/// Measures the cycles of a process and publishes its health.
pub struct HealthReporter {
    publisher: Publisher<Health>,
    message: Health,
    lateness: Histogram,
    body: Histogram,
    apply_age: Histogram,
    window_began_ns: u64,
    window_cycles: u64,
    next_ns: u64,
    /// The newest message that was refused: its topic, why, and when it is forgotten.
    refused: Option<(&'static str, Invalid, u64)>,
    /// Published in place of any note.
    fault: Option<Text<NOTE_BYTES>>,
    process: Process,
    lockstep: bool,
    /// `None` in a model, whose cycles take no time.
    overruns: Option<OverrunWatch>,
    /// `None` in a model, and where the run directory has no room for it.
    black_box: Option<BlackBox>,
    generation: u16,
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "seven digits are enough for a plot"
)]
fn single(value: f64) -> f32 {
    value as f32
}

/// Lateness and duration from which a cycle is an overrun (ns).
fn limits(process: Process, is_lockstep: bool) -> (u64, u64) {
    match process {
        // No clock is involved.
        _ if is_lockstep => (u64::MAX, u64::MAX),
        Process::Physics | Process::Controller(_) => (TICK_NS / 2, TICK_NS),
        // The task and the monitor have no grid of deadlines to be late for.
        Process::Task | Process::Monitor => (u64::MAX, DECISION_TICKS * TICK_NS),
    }
}

/// The ring of the last cycles of `process`.
// An incident without this ring is poorer; a process that does not start for it is worse.
fn black_box(start: &Start, process: Process) -> Option<BlackBox> {
    let black_box = BlackBox::open(&ring_path(&start.spec.run_dir, &process.name()));
    if let Err(error) = &black_box {
        crate::warn(format_args!(
            "no black box, incidents will not show this process: {error}"
        ));
    }
    black_box.ok()
}

impl HealthReporter {
    /// The reporter of `process`, for cycles of the calling thread; its first window starts at
    /// `now_ns`.
    pub fn new(
        start: &Start,
        bus: &Bus,
        process: Process,
        fifo: bool,
        now_ns: u64,
    ) -> Result<Self, BusError> {
        let mut message: Health = ipc_types::Wire::zeroed();
        message.pid = std::process::id();
        message.scheduling = if fifo {
            Scheduling::Fifo
        } else {
            Scheduling::Other
        }
        .code();
        let lockstep = start.spec.speed.is_lockstep();
        let (late_ns, body_ns) = limits(process, lockstep);
        let is_modelled = start.is_modelled();
        let watch = || OverrunWatch::of_this_thread(late_ns, body_ns);
        Ok(Self {
            overruns: (!is_modelled).then(watch),
            black_box: (!is_modelled).then(|| black_box(start, process)).flatten(),
            process,
            lockstep,
            // The ring keeps 16 bits: enough to tell the starts within its four seconds apart.
            generation: u16::try_from(start.generation & 0xffff).unwrap_or(0),
            publisher: bus.publisher(TopicId::Health(process))?,
            message,
            lateness: Histogram::new(),
            body: Histogram::new(),
            apply_age: Histogram::new(),
            window_began_ns: now_ns,
            window_cycles: 0,
            next_ns: 0,
            refused: None,
            fault: None,
        })
    }

    /// Counts a cycle that worked on `tick`, started at `began_ns`, `late_ns` after its
    /// deadline, and ended at `now_ns`; `values` are kept with it in the black box, under the names of
    /// [`cell_run::incident::value_names`].
    pub fn cycle(
        &mut self,
        tick: u64,
        began_ns: u64,
        late_ns: u64,
        values: [f64; VALUES],
        now_ns: u64,
    ) {
        let body_ns = now_ns.saturating_sub(began_ns);
        self.message.cycles += 1;
        self.window_cycles += 1;
        self.lateness.record(late_ns);
        self.body.record(body_ns);
        // Looked up now: a few cycles later the kernel's counters include other delays.
        let watch = self.overruns.as_mut();
        let cause = watch.and_then(|watch| watch.cycle(late_ns, body_ns));
        let short = |ns: u64| u32::try_from(ns).unwrap_or(u32::MAX);
        if let Some(black_box) = &mut self.black_box {
            black_box.add(&BoxedCycle {
                generation: self.generation,
                tick,
                began_ns,
                late_ns: short(late_ns),
                body_ns: short(body_ns),
                cause,
                values: values.map(single),
            });
        }
    }

    /// Sets how simulated time passes from now on: in lockstep no cycle is late.
    pub fn set_lockstep(&mut self, lockstep: bool) {
        if std::mem::replace(&mut self.lockstep, lockstep) != lockstep {
            let (late_ns, body_ns) = limits(self.process, lockstep);
            if let Some(watch) = &mut self.overruns {
                watch.set_limits(late_ns, body_ns);
            }
        }
    }

    /// Counts a loop of a process that waits: it is alive without work.
    pub fn idle(&mut self) {
        self.message.cycles += 1;
    }

    /// Age of the state whose command is applied now (ns).
    pub fn applied(&mut self, age_ns: u64) {
        self.apply_age.record(age_ns);
    }

    /// Totals since the start of the process.
    pub fn totals(&mut self, missed_cycles: u64, rejected: u64, fenced: u64) {
        self.message.missed_cycles = missed_cycles;
        self.message.rejected = rejected;
        self.message.fenced = fenced;
    }

    /// Newest trouble in words; empty for none.
    pub fn note(&mut self, note: &str) {
        // Compared first: formatting a text at 1 kHz costs more than comparing it.
        if self.message.note.as_str() != note {
            self.message.note = Text::new(note);
        }
    }

    /// An event of which an incident is kept, in words.
    pub fn incident(&mut self, what: &str) {
        self.message.incidents += 1;
        self.note(what);
    }

    /// Publishes a fault, in up to 185 bytes, until it is removed (`None`): a promise of the
    /// cell that does not hold at present. It hides every note: `status`, `top`, the page and
    /// the launcher show it at once, the summary of the run at the end.
    pub fn fault(&mut self, fault: Option<&str>) {
        self.fault = fault.map(|fault| Text::format(format_args!("{FAULT}{fault}")));
    }

    /// Records that a message of `topic` was refused, if `invalid` has the reason. It is
    /// published for some seconds while there is no other note.
    pub fn refused(&mut self, topic: &'static str, invalid: Option<Invalid>, now_ns: u64) {
        if let Some(invalid) = invalid {
            self.refused = Some((topic, invalid, now_ns + REFUSED_NS));
        }
    }

    /// Publishes if the period is over; `tick` is the newest this process has seen.
    pub fn publish_if_due(&mut self, tick: u64, now_ns: u64) {
        if now_ns < self.next_ns {
            return;
        }
        self.next_ns = now_ns + PERIOD_NS;
        // The window is closed before the message is made, so
        // its figures are of a whole window.
        let window_ns = now_ns.saturating_sub(self.window_began_ns);
        if window_ns >= WINDOW_NS {
            self.close_window(window_ns);
            self.window_began_ns = now_ns;
        }
        self.message.header = Header::caused_by::<Health>(tick);
        self.refused.take_if(|(.., until_ns)| now_ns > *until_ns);
        // A copy: the note of the process must be there again
        // once the refusal or fault has passed.
        let mut message = self.message;
        if let (true, Some((topic, invalid, _))) = (message.note.is_empty(), &self.refused) {
            message.note = Text::format(format_args!("refused a {topic}: {invalid}"));
        }
        if let Some(fault) = self.fault {
            message.note = fault;
        }
        // A message that was not sent is followed by another one after 10 ms.
        let _sent = self.publisher.publish(|slot| *slot = message).is_ok();
    }

    fn close_window(&mut self, window_ns: u64) {
        let figures = &mut self.message;
        figures.rate_hz = self.window_cycles as f64 * 1.0e9 / window_ns as f64;
        figures.lateness_p50_ns = self.lateness.percentile(50.0) as f64;
        figures.lateness_p99_ns = self.lateness.percentile(99.0) as f64;
        figures.lateness_max_ns = self.lateness.max() as f64;
        figures.body_p50_ns = self.body.percentile(50.0) as f64;
        figures.body_p99_ns = self.body.percentile(99.0) as f64;
        figures.apply_age_p50_ns = self.apply_age.percentile(50.0) as f64;
        figures.apply_age_p99_ns = self.apply_age.percentile(99.0) as f64;
        self.window_cycles = 0;
        for histogram in [&mut self.lateness, &mut self.body, &mut self.apply_age] {
            histogram.clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_loop_with_deadlines_is_late_and_none_is_in_lockstep() {
        for process in [Process::Physics, Process::Controller(1)] {
            assert_eq!(limits(process, false), (500_000, 1_000_000));
        }
        for process in [Process::Task, Process::Monitor] {
            assert_eq!(limits(process, false), (u64::MAX, 10_000_000));
        }
        for process in Process::all(2) {
            assert_eq!(limits(process, true), (u64::MAX, u64::MAX), "{process:?}");
        }
    }
}
