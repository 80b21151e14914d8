//! `robocell doctor --measure`: a loop of 1 kHz as physics has it, for ten seconds.

use cell_rt::overrun::{Cause, OverrunWatch};
use cell_rt::priority::{PHYSICS_PRIORITY, request};
use cell_rt::{Grid, Histogram, monotonic_ns};
use schemars::JsonSchema;
use serde::Serialize;
use supervisor::failure::{Context, Failure};

/// Period of the loop (ns).
const PERIOD_NS: u64 = 1_000_000;
/// A cycle later than this counts as late (ns): what follows it in the same period has
/// half of it.
const LATE_NS: u64 = 500_000;
/// Physics brakes an arm when a command is older (ns).
const HOLD_NS: u64 = 17_000_000;
/// Share of cycles in time for a machine that is fit, and for one that is usable.
const FIT: f64 = 0.999;
const USABLE: f64 = 0.95;

/// What the loop met.
#[derive(Debug, Default, Serialize, JsonSchema)]
pub(super) struct Measured {
    cycles: u64,
    fifo: bool,
    late_cycles: u64,
    late_p50_us: f64,
    late_p99_us: f64,
    late_max_us: f64,
    /// Late cycles by cause.
    causes: std::collections::BTreeMap<&'static str, u64>,
    pub(super) verdict: &'static str,
    pub(super) advice: String,
}

/// Runs the loop for `seconds`.
pub(super) fn measure(seconds: u64) -> Result<Measured, Failure> {
    // A thread of its own: it ends with its priority.
    let work = move || run(seconds * 1_000_000_000 / PERIOD_NS);
    let thread = std::thread::Builder::new().name("measure".to_owned());
    let thread = thread.spawn(work).cannot("start a thread")?;
    thread
        .join()
        .map_err(|_| Failure::configuration("the measuring thread ended early"))
}

fn run(cycles: u64) -> Measured {
    let fifo = request(PHYSICS_PRIORITY, None).fifo;
    let mut lateness = Histogram::new();
    let mut measured = Measured {
        cycles,
        fifo,
        ..Measured::default()
    };
    let mut watch = OverrunWatch::of_this_thread(LATE_NS, u64::MAX);
    let mut grid = Grid::new(PERIOD_NS, monotonic_ns(), fifo);
    for _ in 0..cycles {
        let late_ns = grid.wait().lateness_ns();
        lateness.record(late_ns);
        if let Some(cause) = watch.cycle(late_ns, 0) {
            measured.late_cycles += 1;
            *measured.causes.entry(cause.name()).or_default() += 1;
        }
    }
    let us = |ns: u64| ns as f64 * 1.0e-3;
    measured.late_p50_us = us(lateness.percentile(50.0));
    measured.late_p99_us = us(lateness.percentile(99.0));
    measured.late_max_us = us(lateness.max());
    measured.judge();
    measured
}

impl Measured {
    fn judge(&mut self) {
        let in_time = 1.0 - self.late_cycles as f64 / self.cycles.max(1) as f64;
        let holds = self.late_max_us * 1.0e3 > HOLD_NS as f64;
        self.verdict = match in_time {
            // A single cycle that is this late makes physics brake an arm.
            _ if holds => "unfit",
            share if share >= FIT => "fit",
            share if share >= USABLE => "usable",
            _ => "unfit",
        };
        let most = self.causes.iter().max_by_key(|(_, count)| **count);
        let most = most.map(|(name, _)| *name);
        let advice = match (self.verdict, most) {
            ("fit", _) => "real time works on this machine",
            (_, Some(name)) if name == Cause::StealTime.name() => {
                "other virtual machines take the cores: give this one its own cores, or run \
                 in lockstep (`--speed max`)"
            }
            (_, Some(name)) if name == Cause::PageFault.name() => {
                "memory is short: end other programs, or allow locked memory (see above)"
            }
            (_, Some(name)) if name == Cause::Preemption.name() => {
                "other programs have the cores: end them, or allow SCHED_FIFO (see above)"
            }
            _ => {
                "the kernel wakes up late: switch off power saving, or use a kernel with PREEMPT_RT"
            }
        };
        advice.clone_into(&mut self.advice);
    }
}

impl std::fmt::Display for Measured {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let class = if self.fifo {
            "SCHED_FIFO"
        } else {
            "no real-time priority"
        };
        writeln!(
            f,
            "{} cycles of 1 ms, {class}: late by {:.0} us (p50), {:.0} us (p99), {:.0} us (max); \
             {} by more than 500 us",
            self.cycles, self.late_p50_us, self.late_p99_us, self.late_max_us, self.late_cycles
        )?;
        for (name, count) in &self.causes {
            writeln!(f, "  {name:<12} {count}")?;
        }
        write!(f, "verdict: {}; {}", self.verdict, self.advice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn judged(late_cycles: u64, max_us: f64, cause: Cause) -> Measured {
        let mut measured = Measured {
            cycles: 10_000,
            late_cycles,
            late_max_us: max_us,
            causes: [(cause.name(), late_cycles)].into(),
            ..Measured::default()
        };
        measured.judge();
        measured
    }

    #[test]
    fn the_verdict_follows_the_share_in_time_and_the_longest_gap() {
        assert_eq!(judged(5, 900.0, Cause::WakeUp).verdict, "fit");
        assert_eq!(judged(50, 900.0, Cause::WakeUp).verdict, "usable");
        assert_eq!(judged(600, 900.0, Cause::WakeUp).verdict, "unfit");
        let stalled = judged(1, 20_000.0, Cause::StealTime);
        assert_eq!(stalled.verdict, "unfit");
        assert!(stalled.advice.contains("virtual machines"));
        assert!(
            judged(50, 900.0, Cause::Preemption)
                .advice
                .contains("SCHED_FIFO")
        );
    }

    #[test]
    fn a_short_measurement_counts_every_cycle() {
        let measured = run(50);
        assert_eq!(measured.cycles, 50);
        assert!(measured.late_p50_us <= measured.late_max_us);
        let causes: u64 = measured.causes.values().sum();
        assert_eq!(causes, measured.late_cycles);
    }
}
