//! Which action of which answer is in force: chunks of actions with a latency that is simulated
//! time. Pure.
//!
//! The observation of step k is sent, and its answer is in force from the first step at or after
//! k + latency on. Rows whose time has passed by then are skipped. The next observation is sent
//! when half of the rows in force are used; one is on its way at a time. It tells where the arm
//! was sent in the step before, so none is sent in the step in which an older answer comes into force.

use serde::{Deserialize, Serialize};

use crate::codec::Rows;

/// Period of an action (ms, and ticks).
pub const STEP_MS: u64 = 50;

/// An answer in force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Chunk {
    /// Step of its first row.
    begin: u64,
    rows: Rows,
}

/// An observation that was sent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Sent {
    step: u64,
    answer: Option<Rows>,
}

/// The answers of an episode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    in_force: Option<Chunk>,
    sent: Option<Sent>,
    /// Observations that were sent.
    pub requests: u64,
    /// Steps without a row of their own.
    pub stale_steps: u64,
}

impl Schedule {
    /// Whether the observation of `step` is to be sent.
    pub fn asks(&self, step: u64) -> bool {
        let used = |chunk: &Chunk| {
            step.saturating_sub(chunk.begin) >= (chunk.rows.len() as u64).div_ceil(2)
        };
        self.sent.is_none() && self.in_force.as_ref().is_none_or(used)
    }

    /// The observation of `step` was sent.
    pub fn send(&mut self, step: u64) {
        self.requests += 1;
        self.sent = Some(Sent { step, answer: None });
    }

    /// Whether an answer is on its way.
    pub fn waits(&self) -> bool {
        self.sent.as_ref().is_some_and(|sent| sent.answer.is_none())
    }

    /// The answer to the observation that was sent.
    pub fn answer(&mut self, rows: Rows) {
        if let Some(sent) = &mut self.sent {
            sent.answer = Some(rows);
        }
    }

    /// Forgets an observation without an answer, after the connection was closed.
    pub fn resume(&mut self) {
        if self.waits() {
            self.sent = None;
        }
    }

    /// Forgets all answers; the counts stay.
    pub fn restart(&mut self) {
        (self.in_force, self.sent) = (None, None);
    }

    /// The action of `step`, and whether it is stale; `None` before the first answer.
    pub fn action(&mut self, step: u64, latency_ms: u32) -> Option<(&[f32], bool)> {
        let is_due = |sent: &mut Sent| {
            sent.answer.is_some() && step * STEP_MS >= sent.step * STEP_MS + u64::from(latency_ms)
        };
        if let Some(Sent { step, answer }) = self.sent.take_if(is_due) {
            self.in_force = answer.map(|rows| Chunk { begin: step, rows });
        }
        let Some(chunk) = &self.in_force else {
            self.stale_steps += 1;
            return None;
        };
        let passed = usize::try_from(step.saturating_sub(chunk.begin)).unwrap_or(usize::MAX);
        let stale = passed >= chunk.rows.len();
        self.stale_steps += u64::from(stale);
        let row = chunk.rows.get(passed).or(chunk.rows.last())?;
        Some((row, stale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows that tell step and place.
    fn rows(step: u64, count: usize) -> Rows {
        (0..count)
            .map(|row| vec![step as f32, row as f32])
            .collect()
    }

    /// Steps at which observations are sent, and the actions.
    fn run(steps: u64, latency_ms: u32, count: usize) -> (Vec<u64>, Vec<Vec<f32>>, Schedule) {
        let mut schedule = Schedule::default();
        let (mut sent, mut actions) = (Vec::new(), Vec::new());
        for step in 0..steps {
            if schedule.asks(step) {
                sent.push(step);
                schedule.send(step);
                schedule.answer(rows(step, count));
            }
            let action = schedule.action(step, latency_ms);
            actions.push(action.map_or_else(Vec::new, |(row, _)| row.to_vec()));
        }
        (sent, actions, schedule)
    }

    #[test]
    fn half_of_a_chunk_is_used_without_latency() {
        let (sent, actions, schedule) = run(9, 0, 8);
        assert_eq!(sent, [0, 4, 8]);
        assert_eq!(actions[3], [0.0, 3.0]);
        assert_eq!(actions[4], [4.0, 0.0]);
        assert_eq!((schedule.requests, schedule.stale_steps), (3, 0));
    }

    #[test]
    fn rows_whose_time_has_passed_are_skipped() {
        // 120 ms: in force from the third step after it was sent.
        let (sent, actions, schedule) = run(8, 120, 8);
        assert_eq!(sent, [0, 4]);
        assert_eq!(actions[2], Vec::<f32>::new());
        assert_eq!(actions[3], [0.0, 3.0]);
        assert_eq!(actions[6], [0.0, 6.0]);
        assert_eq!(actions[7], [4.0, 3.0]);
        assert_eq!(schedule.stale_steps, 3);
    }

    #[test]
    fn the_last_row_is_repeated_and_counted_as_stale() {
        let (sent, actions, schedule) = run(12, 400, 4);
        assert_eq!(sent, [0, 9]);
        // All rows are in the past once the answer is there.
        assert_eq!(actions[8], [0.0, 3.0]);
        assert_eq!(schedule.stale_steps, 12);
    }

    #[test]
    fn an_answer_that_was_on_its_way_is_asked_for_again() {
        let mut schedule = Schedule::default();
        schedule.send(0);
        assert!(schedule.waits() && !schedule.asks(3));
        schedule.resume();
        assert!(schedule.asks(3));
    }
}
