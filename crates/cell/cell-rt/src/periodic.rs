//! An absolute grid of deadlines: sleep most of the way, spin for the rest.
//!
//! A relative sleep adds its lateness to every period: the transport's timers drift by 0.5 to
//! 1.3 %. And a sleeping thread wakes some 10 µs late even with real-time priority. So
//! deadlines are absolute, and the last part is spun. A change must not catch up on missed
//! cycles: a burst would break limits of acceleration (ADR 0003).

use crate::clock::{monotonic_ns, sleep_until};

/// How long before a deadline a real-time thread stops sleeping: longer than
/// nearly every wake-up of a sleeping thread.
// Median lateness 0.1 µs with 150 µs of spinning, 12 µs without; costs 15 % of a core.
pub const SPIN_FIFO_NS: u64 = 150_000;
/// The same for a thread of the normal class, which must not hold a core long.
// With more, a thread that shares its core would take it from the others.
pub const SPIN_OTHER_NS: u64 = 50_000;

/// Planned and actual start of a cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wake {
    /// Planned start, [`monotonic_ns`].
    pub deadline_ns: u64,
    /// Actual start.
    pub woke_ns: u64,
}

impl Wake {
    /// How late the cycle started, nanoseconds.
    pub fn lateness_ns(&self) -> u64 {
        self.woke_ns.saturating_sub(self.deadline_ns)
    }
}

/// Deadlines one period apart. A cycle that runs over its period shifts the
/// whole grid: there is always a rest of an eighth of a period between the end
/// of one cycle and the start of the next, so others can answer, and missed
/// cycles are never caught up in a burst.
#[derive(Clone, Debug)]
pub struct Grid {
    period_ns: u64,
    spin_ns: u64,
    deadline_ns: u64,
    overruns: u64,
}

impl Grid {
    /// A grid whose first deadline is one period from `now_ns`. `fifo`: whether the thread has
    /// real-time priority.
    pub fn new(period_ns: u64, now_ns: u64, fifo: bool) -> Self {
        let spin_ns = if fifo { SPIN_FIFO_NS } else { SPIN_OTHER_NS };
        Self {
            period_ns,
            spin_ns,
            deadline_ns: now_ns + period_ns,
            overruns: 0,
        }
    }

    /// Starts again, one period from `now_ns`: after a pause of the loop.
    pub fn restart(&mut self, now_ns: u64) {
        self.deadline_ns = now_ns + self.period_ns;
    }

    /// Next deadline.
    pub fn deadline_ns(&self) -> u64 {
        self.deadline_ns
    }

    /// Cycles that were not done at their successor's deadline.
    pub fn overruns(&self) -> u64 {
        self.overruns
    }

    /// Waits for the next deadline.
    pub fn wait(&mut self) -> Wake {
        let deadline_ns = self.plan(monotonic_ns());
        self.woke(wait_until(deadline_ns, self.spin_ns))
    }

    /// How long before a deadline the thread stops sleeping.
    pub fn spin_ns(&self) -> u64 {
        self.spin_ns
    }

    /// The deadline for a cycle that is waited for from `now_ns` on, shifting
    /// the grid if the cycle before ran over.
    pub fn plan(&mut self, now_ns: u64) -> u64 {
        if now_ns > self.deadline_ns {
            self.overruns += 1;
        }
        // An eighth of a period: others on the same core need
        // time to answer before the next cycle.
        self.deadline_ns = self.deadline_ns.max(now_ns + self.period_ns / 8);
        self.deadline_ns
    }

    /// Sets the deadline after a cycle that started at `woke_ns`. Ordinary lateness keeps the
    /// grid, so there is no drift. A cycle that started a whole period late starts a new grid.
    pub fn woke(&mut self, woke_ns: u64) -> Wake {
        let deadline_ns = self.deadline_ns;
        if woke_ns >= self.deadline_ns + self.period_ns {
            self.overruns += 1;
            self.deadline_ns = woke_ns;
        }
        self.deadline_ns += self.period_ns;
        Wake {
            deadline_ns,
            woke_ns,
        }
    }
}

/// Sleeps until `spin_ns` before `deadline_ns` and spins for the rest; returns the time of the
/// end.
pub fn wait_until(deadline_ns: u64, spin_ns: u64) -> u64 {
    // Interrupts and slow wake-ups fall into the part that is spun anyway.
    sleep_until(deadline_ns.saturating_sub(spin_ns));
    let mut woke_ns = monotonic_ns();
    while woke_ns < deadline_ns {
        core::hint::spin_loop();
        woke_ns = monotonic_ns();
    }
    woke_ns
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    #[test]
    fn lateness_does_not_move_the_grid() {
        let mut grid = Grid::new(MS, 0, true);
        for cycle in 1..100 {
            assert_eq!(grid.plan(cycle * MS - 700_000), cycle * MS);
            grid.woke(cycle * MS + 90_000);
        }
        assert_eq!(grid.overruns(), 0);
    }

    #[test]
    fn an_overrun_shifts_the_grid_and_leaves_a_rest() {
        let mut grid = Grid::new(MS, 0, true);
        assert_eq!(grid.plan(0), MS);
        grid.woke(MS);
        // The body took 5.3 periods.
        let next = grid.plan(6_300_000);
        assert_eq!(next, 6_300_000 + MS / 8);
        grid.woke(next);
        assert_eq!(grid.plan(next + 100_000), next + MS, "no burst to catch up");
        assert_eq!(grid.overruns(), 1);
    }

    #[test]
    fn a_cycle_that_slept_over_starts_a_new_grid() {
        let mut grid = Grid::new(MS, 0, true);
        grid.plan(0);
        grid.woke(9 * MS);
        assert_eq!(grid.plan(9 * MS + 10), 10 * MS);
        assert_eq!(grid.overruns(), 1);
    }

    #[test]
    fn no_cycle_starts_before_its_deadline() {
        let mut grid = Grid::new(MS, monotonic_ns(), false);
        let mut last = 0;
        for _ in 0..20 {
            let wake = grid.wait();
            assert!(wake.woke_ns >= wake.deadline_ns);
            assert!(wake.deadline_ns > last);
            last = wake.deadline_ns;
        }
    }
}
