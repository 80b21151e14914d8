//! Publishes a recording to the page, at the pace of its clock.

use std::sync::Arc;

use serde_json::Value;

use super::clock::Clock;
use super::page_record::{PageRecord, line_time_s};
use crate::feed::broadcast::{Broadcast, RecordedSpan};
use crate::feed::status::{StatusInput, status};
use crate::page::command::PlayOrder;
use crate::timeline::recorded::RecordingSource;
use crate::trace::{KEPT_LINES, TraceModel, log_line};

/// Part of the trace before a new time that is sent (s): pictures are in the trace once a
/// second, values and transitions when they change.
const LOOK_BACK_S: f64 = 10.0;
/// A longer step is a jump, not playing (s).
// At 50 times real time a frame is 0.8 s; a slow disk may skip several.
const JUMP_S: f64 = 5.0;
/// Time after its start within which a recording has a complete state (s).
const BEGINS_S: f64 = 5.0;
/// Interval of the status messages (s).
const STATUS_S: f64 = 0.25;

/// Shows a recording.
pub struct Player<F> {
    recording: F,
    broadcast: Arc<Broadcast>,
    clock: Clock,
    fingers: Vec<usize>,
    objects: Vec<String>,
    policy: String,
    record: Arc<PageRecord>,
    /// Time shown on the page (s).
    shown_s: Option<f64>,
    next_status_s: f64,
    in_trouble: bool,
}

impl<F: RecordingSource> Player<F> {
    /// A player at the start of `recording`. `fingers` as in [`crate::feed::scene::fingers`],
    /// `objects` by their place in the cell file, `policy` for a task without its own.
    pub(super) fn new(
        recording: F,
        record: Arc<PageRecord>,
        broadcast: Arc<Broadcast>,
        fingers: Vec<usize>,
        objects: Vec<String>,
        policy: String,
    ) -> Self {
        let clock = Clock::new(recording.span_s());
        Self {
            recording,
            broadcast,
            clock,
            fingers,
            objects,
            policy,
            record,
            shown_s: None,
            next_status_s: 0.0,
            in_trouble: false,
        }
    }

    /// Executes an order of a page.
    pub fn apply(&mut self, order: PlayOrder) {
        self.clock.apply(order);
    }

    /// Shows the moment of `now_s` of the monotonic clock.
    pub fn update(&mut self, now_s: f64) {
        let time_s = self.clock.advance(now_s);
        let due = now_s >= self.next_status_s;
        match self.show(time_s, due) {
            Ok(()) => self.in_trouble = false,
            Err(why) => self.report_problem(time_s, &why),
        }
        if due {
            self.next_status_s = now_s + STATUS_S;
            let (from_s, to_s) = self.recording.span_s();
            self.broadcast.publish_recorded_span(&RecordedSpan {
                from_s,
                to_s,
                epochs: Vec::new(),
            });
        }
        self.broadcast.publish_trace();
    }

    /// Reports once why a moment cannot be shown. At the start of a recording there may be no
    /// complete state yet, which is not a fault.
    fn report_problem(&mut self, time_s: f64, why: &str) {
        let begins = time_s < self.recording.span_s().0 + BEGINS_S;
        if !self.in_trouble && !begins {
            let text = format!("[fault] the recording: {why}");
            self.broadcast.add_log_line(time_s, "lifecycle", &text);
        }
        self.in_trouble = !begins;
    }

    fn show(&mut self, time_s: f64, with_status: bool) -> Result<(), String> {
        let mut state = self.recording.state_at(time_s)?;
        // A paused replay sends no trace: it has not changed.
        let moved = self.shown_s != Some(time_s);
        if moved {
            self.publish_trace_to(time_s)?;
            self.shown_s = Some(time_s);
        }
        // The pause shown is that of the replay.
        let paused = ipc_types::world::FLAG_PAUSED;
        state.world.flags &= !paused;
        if !self.clock.plays {
            state.world.flags |= paused;
        }
        let factor = if self.clock.plays {
            self.clock.speed
        } else {
            0.0
        };
        self.broadcast.frame(state.frame(&self.fingers, factor, 0));
        if with_status {
            let message = status(&StatusInput {
                processes: &[],
                missed: &[],
                world: Some(&state.world),
                decision: Some(&state.decision),
                objects: &self.objects,
                breaks: &[],
                policy: &self.policy,
            });
            self.broadcast.publish_status(&message);
        }
        Ok(())
    }

    /// Sends the task's trace up to `time_s`: the next lines, or all of it again.
    fn publish_trace_to(&mut self, time_s: f64) -> Result<(), String> {
        match self.shown_s {
            // Forward by a little: the lines between; anything else is a jump.
            Some(shown_s) if (shown_s..shown_s + JUMP_S).contains(&time_s) => {
                for line in self.recording.trace(shown_s, time_s)? {
                    self.broadcast.take_line(&line);
                }
                let lines = self.record.lines_until(time_s);
                let new = lines.iter().filter(|line| line_time_s(line) > shown_s);
                self.broadcast.add_recorded(new.cloned());
            }
            _ => {
                // Log and pictures apart: the log reaches far back,
                // pictures only need the last seconds.
                let mut trace = TraceModel::default();
                let of_task = self.recording.log_until(time_s, KEPT_LINES)?;
                let mut lines: Vec<Value> = of_task.iter().map(log_line).collect();
                lines.extend_from_slice(self.record.lines_until(time_s));
                lines.sort_by(|a, b| line_time_s(a).total_cmp(&line_time_s(b)));
                for line in lines {
                    trace.add_recorded(line);
                }
                for line in self.recording.trace(time_s - LOOK_BACK_S, time_s)? {
                    trace.take_picture(&line);
                }
                self.broadcast.replace_trace(trace);
            }
        }
        Ok(())
    }
}
