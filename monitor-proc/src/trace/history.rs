//! Statuses of the task's pictures every few seconds: from there the trace in a recording leads
//! to any moment. Values are sent only when they change, so a piece of the trace alone is not
//! enough.

use std::collections::VecDeque;

use super::TraceModel;

/// Simulated time between two entries (s).
// Bounds the trace that is read for one moment of the past.
const SPACING_S: f64 = 5.0;
/// Together as long as the flight recorder's ring: about ten minutes.
const KEPT: usize = 128;

/// Pictures by simulated time.
#[derive(Clone, Debug, Default)]
pub struct TraceHistory {
    kept: VecDeque<(f64, TraceModel)>,
    last_s: f64,
}

impl TraceHistory {
    /// Announces a line of `time_s`; `trace` is the state before it.
    pub fn next(&mut self, time_s: f64, trace: &TraceModel) {
        if time_s < self.last_s {
            // Physics was restarted: it resumed at an earlier time.
            self.kept.retain(|(at, _)| *at <= time_s);
        // Between two times only: a trace in the middle of a tick is incomplete.
        } else if time_s > self.last_s {
            let last_s = self.kept.back().map_or(f64::NEG_INFINITY, |(at, _)| *at);
            if self.last_s >= last_s + SPACING_S {
                self.kept.push_back((self.last_s, trace.without_log()));
            }
            if self.kept.len() > KEPT {
                self.kept.pop_front();
            }
        }
        self.last_s = time_s;
    }

    /// The newest entry not after `time_s`, with its time.
    pub fn before(&self, time_s: f64) -> Option<(f64, TraceModel)> {
        let found = self.kept.iter().rev().find(|(at, _)| *at <= time_s);
        found.cloned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn history_of(times_s: impl IntoIterator<Item = f64>) -> TraceHistory {
        let mut history = TraceHistory::default();
        for time_s in times_s {
            history.next(time_s, &TraceModel::default());
        }
        history
    }

    fn at(history: &TraceHistory, time_s: f64) -> Option<f64> {
        history.before(time_s).map(|(at, _)| at)
    }

    #[test]
    fn the_last_before_a_moment_is_found_and_the_oldest_are_forgotten() {
        let history = history_of((1..1000).map(f64::from));
        let found = at(&history, 998.0).unwrap();
        assert!((990.0..=998.0).contains(&found), "{found}");
        assert!(at(&history, 500.0).is_some_and(|at| (494.0..=500.0).contains(&at)));
        assert_eq!(at(&history, 100.0), None);
    }

    #[test]
    fn what_came_after_the_time_physics_resumed_at_is_forgotten() {
        let history = history_of([1.0, 10.0, 20.0, 30.0, 19.0]);
        assert_eq!(at(&history, 25.0), Some(10.0));
        assert_eq!(at(&history_of([1.0, 10.0, 20.0, 0.5]), 25.0), Some(0.0));
    }
}
