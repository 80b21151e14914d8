//! The loop of a process: turns that do the work, and the waits between them.
//!
//! A loop never waits by itself. It returns how to wait for its next turn, so that one thread
//! can also run all loops of a cell in virtual time. In a process [`run`] does the waiting; what
//! it costs is part of the lateness of every cycle, so a change here is measured with
//! `bench loop` and `bench e2e`.

use std::time::Duration;

use cell_bus::Sleeper;
use cell_rt::periodic::wait_until;
use cell_rt::signal::stop_requested;
use cell_rt::{Grid, monotonic_ns, sleep_until};

/// Longest sleep of a loop that waits for a doorbell; then it serves late subscribers, repeats
/// its messages and publishes its health.
// Half of a decision period: if a doorbell is lost, the next decision is at most 5 ms late. Far
// below the 100 ms after which a silent process counts as hung, and too rare to cost a core.
const NUDGE: Duration = Duration::from_millis(5);

/// How a loop waits for its next turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// Until `at_ns` exactly: a sleep, and `spin_ns` of spinning at the end.
    Deadline {
        /// Time of the next turn.
        at_ns: u64,
        /// Length of the spinning at the end.
        spin_ns: u64,
    },
    /// For the next turn at once: it polls for a message that is due within microseconds.
    Spin,
    /// As [`Wait::Spin`], after the threads that wait for this core.
    Yield,
    /// A sleep until this time, or a little longer.
    Sleep(u64),
    /// A sleep until the doorbell rings, 5 ms at most.
    Bell,
}

impl Wait {
    /// For the next deadline of `grid`, from `now_ns` on.
    pub fn next_of(grid: &mut Grid, now_ns: u64) -> Self {
        Self::Deadline {
            at_ns: grid.plan(now_ns),
            spin_ns: grid.spin_ns(),
        }
    }
}

/// The end of a wait.
#[derive(Clone, Copy, Debug)]
pub struct Woken {
    /// The time of the clock of the loop.
    pub now_ns: u64,
    /// Whether a doorbell ended the wait.
    pub by_bell: bool,
}

/// A loop.
pub trait Turn {
    /// Works with the messages that have arrived, and never waits for others.
    fn turn(&mut self, woken: Woken) -> Wait;
}

impl Woken {
    fn now(by_bell: bool) -> Self {
        let now_ns = monotonic_ns();
        Self { now_ns, by_bell }
    }
}

/// Runs `turns` until this process is asked to stop.
// Generic, so that the compiler joins the waits with the turns, as in a loop written by hand.
pub fn run(turns: &mut impl Turn, bell: &mut Sleeper) {
    let mut woken = Woken::now(false);
    // Checked before each turn, so a loop that waits for another process stops soon, too: a
    // signal ends the sleep at the doorbell.
    while !stop_requested() {
        woken = match turns.turn(woken) {
            // The last reading of the spinning is the start of the cycle.
            Wait::Deadline { at_ns, spin_ns } => Woken {
                now_ns: wait_until(at_ns, spin_ns),
                by_bell: false,
            },
            Wait::Spin => {
                std::hint::spin_loop();
                Woken::now(false)
            }
            Wait::Yield => {
                std::thread::yield_now();
                Woken::now(false)
            }
            Wait::Sleep(until_ns) => {
                sleep_until(until_ns);
                Woken::now(false)
            }
            Wait::Bell => Woken::now(bell.wait(NUDGE)),
        };
    }
}
