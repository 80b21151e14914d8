//! Policy time: simulated time minus the time the task was paused.

use serde::{Deserialize, Serialize};

/// Ticks in a second.
const TICKS_PER_SECOND: f64 = 1.0e9 / ipc_types::TICK_NS as f64;

/// Policy time, or a length of it, in whole ticks of 1 ms: sums and comparisons
/// are exact, so a deadline falls on the same decision in every run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PolicyTime(u64);

impl PolicyTime {
    /// `ticks` of 1 ms.
    pub const fn from_ticks(ticks: u64) -> Self {
        Self(ticks)
    }

    /// The nearest whole tick; zero for negative or non-finite `seconds`.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "the conversion saturates, and a negative or NaN length is no length"
    )]
    pub fn from_seconds(seconds: f64) -> Self {
        Self((seconds * TICKS_PER_SECOND).round() as u64)
    }

    /// Whole ticks of 1 ms.
    pub const fn ticks(self) -> u64 {
        self.0
    }

    /// Seconds.
    pub fn seconds(self) -> f64 {
        self.0 as f64 / TICKS_PER_SECOND
    }

    /// Length since `earlier`, zero where that is in the future.
    pub fn since(self, earlier: Self) -> Self {
        Self(self.0.saturating_sub(earlier.0))
    }
}

/// Upper limit of a clock in a checkpoint that is accepted: 146 million years.
// A larger one is damage, and the next interval could overflow.
const MOST_TICKS: u64 = 1 << 62;

/// Counts policy time from the ticks of the decisions.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct PolicyClock {
    last_tick: Option<u64>,
    elapsed: PolicyTime,
    paused_ticks: u64,
}

impl PolicyClock {
    /// Omits the time up to `tick`: no decision was made then, and the arm held.
    pub fn skip_to(&mut self, tick: u64) {
        self.last_tick = Some(tick);
    }

    /// Advances to the decision at `tick`; the interval before it counts unless the task is
    /// `paused`. Missed decisions count like made ones.
    pub fn advance(&mut self, tick: u64, paused: bool) -> PolicyTime {
        // Without a last tick the interval is zero: a task that starts in a running cell has
        // not waited since tick 0. Saturating, since physics may resume from an earlier tick.
        let interval = tick.saturating_sub(self.last_tick.unwrap_or(tick));
        self.last_tick = Some(tick);
        if paused {
            self.paused_ticks += interval;
        } else {
            self.elapsed = PolicyTime(self.elapsed.0 + interval);
        }
        self.elapsed
    }

    /// Whether a restored clock can continue counting.
    pub(crate) fn is_sound(&self) -> bool {
        // The sum, since both are added to: either alone may be small enough.
        let counted = self.elapsed.0.checked_add(self.paused_ticks);
        counted.is_some_and(|ticks| ticks < MOST_TICKS)
    }

    /// Policy time of the last decision.
    pub fn now(&self) -> PolicyTime {
        self.elapsed
    }

    /// Time the task was paused, all together.
    pub fn paused(&self) -> PolicyTime {
        PolicyTime(self.paused_ticks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pausing_the_task_stops_policy_time() {
        let mut clock = PolicyClock::default();
        assert_eq!(clock.advance(1000, false).seconds(), 0.0);
        assert_eq!(clock.advance(1250, false).seconds(), 0.25);
        assert_eq!(clock.advance(5000, true).seconds(), 0.25);
        assert_eq!(clock.advance(5010, false).seconds(), 0.26);
        assert_eq!(clock.paused().seconds(), 3.75);
    }

    #[test]
    fn a_nonsense_length_is_none() {
        assert_eq!(PolicyTime::from_seconds(f64::NAN), PolicyTime::default());
        assert_eq!(PolicyTime::from_seconds(-1.0), PolicyTime::default());
        assert_eq!(
            PolicyTime::from_seconds(0.250_000_4),
            PolicyTime::from_ticks(250)
        );
    }
}
