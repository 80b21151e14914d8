//! Feeds the hub from a recording, at the pace of its clock.

use std::sync::Arc;

use super::clock::Clock;
use crate::film::Film;
use crate::hub::{Hub, Timeline};
use crate::page::command::PlayOrder;
use crate::status::{StatusInput, status};
use crate::story::{KEPT_LINES, Story};

/// Part of the trace before a new time that is sent (s): pictures are in the trace once a
/// second, values and transitions when they change.
const LOOK_BACK_S: f64 = 10.0;
/// A longer step is a jump, not playing (s).
// At 50 times real time a frame is 0.8 s; a slow disk may skip several.
const LEAP_S: f64 = 5.0;
/// Time after its start within which a recording has a complete state (s).
const BEGINS_S: f64 = 5.0;
/// Interval of the status messages (s).
const STATUS_S: f64 = 0.25;

/// Shows a film.
pub struct Player<F> {
    film: F,
    hub: Arc<Hub>,
    clock: Clock,
    fingers: Vec<usize>,
    objects: Vec<String>,
    policy: String,
    /// Time shown on the page (s).
    shown_s: Option<f64>,
    next_status_s: f64,
    in_trouble: bool,
}

impl<F: Film> Player<F> {
    /// A player at the start of `film`. `fingers` as in [`crate::scene::fingers`], `objects` by
    /// their place in the cell file, `policy` for a task without its own.
    pub fn new(
        film: F,
        hub: Arc<Hub>,
        fingers: Vec<usize>,
        objects: Vec<String>,
        policy: String,
    ) -> Self {
        let clock = Clock::new(film.span_s());
        Self {
            film,
            hub,
            clock,
            fingers,
            objects,
            policy,
            shown_s: None,
            next_status_s: 0.0,
            in_trouble: false,
        }
    }

    /// Executes an order of a page.
    pub fn obey(&mut self, order: PlayOrder) {
        self.clock.obey(order);
    }

    /// Shows the moment of `now_s` of the monotonic clock.
    pub fn turn(&mut self, now_s: f64) {
        let time_s = self.clock.look(now_s);
        let due = now_s >= self.next_status_s;
        match self.show(time_s, due) {
            Ok(()) => self.in_trouble = false,
            Err(why) => self.say_trouble(time_s, &why),
        }
        if due {
            self.next_status_s = now_s + STATUS_S;
            let (from_s, to_s) = self.film.span_s();
            self.hub.tell_timeline(&Timeline {
                from_s,
                to_s,
                epochs: Vec::new(),
            });
        }
        self.hub.tell_news();
    }

    /// Reports once why a moment cannot be shown. At the start of a recording there may be no
    /// complete state yet, which is not a fault.
    fn say_trouble(&mut self, time_s: f64, why: &str) {
        let begins = time_s < self.film.span_s().0 + BEGINS_S;
        if !self.in_trouble && !begins {
            let text = format!("[fault] the recording: {why}");
            self.hub.say(time_s, "lifecycle", &text);
        }
        self.in_trouble = !begins;
    }

    fn show(&mut self, time_s: f64, with_status: bool) -> Result<(), String> {
        let mut still = self.film.still(time_s)?;
        // A paused replay sends no story: it has not changed.
        let moved = self.shown_s != Some(time_s);
        if moved {
            self.tell(time_s)?;
            self.shown_s = Some(time_s);
        }
        // The pause shown is that of the replay.
        let paused = ipc_types::world::FLAG_PAUSED;
        still.world.flags &= !paused;
        if !self.clock.plays {
            still.world.flags |= paused;
        }
        let factor = if self.clock.plays {
            self.clock.speed
        } else {
            0.0
        };
        self.hub.frame(still.frame(&self.fingers, factor, 0));
        if with_status {
            let message = status(&StatusInput {
                processes: &[],
                missed: &[],
                world: Some(&still.world),
                decision: Some(&still.decision),
                objects: &self.objects,
                breaks: &[],
                policy: &self.policy,
            });
            self.hub.tell_status(&message);
        }
        Ok(())
    }

    /// Sends the task's story up to `time_s`: the next lines, or all of it again.
    fn tell(&mut self, time_s: f64) -> Result<(), String> {
        match self.shown_s {
            // Forward by a little: the lines between; anything else is a jump.
            Some(shown_s) if (shown_s..shown_s + LEAP_S).contains(&time_s) => {
                for line in self.film.trace(shown_s, time_s)? {
                    self.hub.take_line(&line);
                }
            }
            _ => {
                // Log and pictures apart: the log reaches far back,
                // pictures only need the last seconds.
                let mut story = Story::default();
                for line in self.film.log_until(time_s, KEPT_LINES)? {
                    story.take(&line);
                }
                for line in self.film.trace(time_s - LOOK_BACK_S, time_s)? {
                    story.take_picture(&line);
                }
                self.hub.forget_story(story);
            }
        }
        Ok(())
    }
}
