//! Feeds the hub from a film, at the pace of its clock.

use std::sync::Arc;

use super::clock::Clock;
use crate::film::Film;
use crate::hub::{Hub, Timeline};
use crate::page::command::PlayOrder;
use crate::status::{StatusInput, status};
use crate::story::{KEPT_LINES, Story};

/// What was said this long before the moment leapt to is told (s): pictures are in
/// the trace once a second, values and transitions when they change.
const LOOK_BACK_S: f64 = 10.0;
/// A leap longer than this is no play any more (s).
const LEAP_S: f64 = 5.0;
/// Within this time after its beginning a recording has a whole state (s).
const BEGINS_S: f64 = 5.0;
/// How often a status is told (s).
const STATUS_S: f64 = 0.25;

/// Shows a film.
pub struct Player<F> {
    film: F,
    hub: Arc<Hub>,
    clock: Clock,
    fingers: Vec<usize>,
    objects: Vec<String>,
    policy: String,
    /// Time the page sees (s).
    shown_s: Option<f64>,
    next_status_s: f64,
    in_trouble: bool,
}

impl<F: Film> Player<F> {
    /// A player at the beginning of `film`. `fingers` as in
    /// [`crate::scene::fingers`], `objects` by their place in the cell file,
    /// `policy` where the task has not said its own.
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

    /// Does what a page asked for.
    pub fn obey(&mut self, order: PlayOrder) {
        self.clock.obey(order);
    }

    /// Shows what is to be seen at `now_s` of the clock on the wall.
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

    /// Says once what cannot be shown. Where a recording begins, there may be no whole
    /// state yet: that is no fault.
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
        let moved = self.shown_s != Some(time_s);
        if moved {
            self.tell(time_s)?;
            self.shown_s = Some(time_s);
        }
        // The pause that is seen is that of the replay.
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

    /// The task's story up to `time_s`: what comes next, or all of it again.
    fn tell(&mut self, time_s: f64) -> Result<(), String> {
        match self.shown_s {
            Some(shown_s) if (shown_s..shown_s + LEAP_S).contains(&time_s) => {
                for line in self.film.trace(shown_s, time_s)? {
                    self.hub.take_line(&line);
                }
            }
            _ => {
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
