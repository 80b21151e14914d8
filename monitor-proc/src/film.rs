//! A recording as shown again.

use ipc_types::{ArmStatus, Decision, TraceLine, WorldState};
use serde_json::{Value, json};

use crate::scrub::{Past, Span, When};
use crate::snapshot::{FLAG_NOT_LIVE, Moment, encode};
use crate::status::{self, StatusInput};
use crate::story::Story;

/// Statuses and pictures of the task are in the trace once a second: this much of it has all.
const PICTURES_S: f64 = 1.1;

/// One moment of a recording.
#[derive(Clone, Debug)]
pub struct Still {
    /// The world.
    pub world: Box<WorldState>,
    /// Status of the controllers.
    pub status: Vec<ArmStatus>,
    /// Decision of the task.
    pub decision: Box<Decision>,
}

/// A recording that can be read.
pub trait Film {
    /// Shows the history of `epoch` from now on, or of the newest.
    fn show_epoch(&mut self, epoch: Option<u32>);

    /// First and last moment of that history (simulated seconds).
    fn span_s(&self) -> (f64, f64);

    /// The newest moment at or before `time_s`.
    ///
    /// # Errors
    ///
    /// The reason why there is none.
    fn still(&mut self, time_s: f64) -> Result<Still, String>;

    /// Trace of the task after `from_s` up to `to_s`, oldest first.
    ///
    /// # Errors
    ///
    /// When it cannot be read.
    fn trace(&mut self, from_s: f64, to_s: f64) -> Result<Vec<TraceLine>, String>;

    /// The last `count` lines for people up to `time_s`, oldest first.
    ///
    /// # Errors
    ///
    /// When they cannot be read.
    fn log_until(&mut self, time_s: f64, count: usize) -> Result<Vec<TraceLine>, String>;
}

impl Still {
    /// The frame of this moment.
    pub fn frame(&self, fingers: &[usize], real_time_factor: f64, flags: u32) -> Vec<u8> {
        // Each status names its arm.
        let of = |arm: usize| self.status.iter().find(|s| s.arm as usize == arm);
        let status: Vec<Option<&ArmStatus>> = (0..self.world.arms().len()).map(of).collect();
        let moment = Moment {
            world: &self.world,
            status: &status,
            decision: Some(&self.decision),
            // Contacts are not recorded.
            contacts: None,
            real_time_factor,
            flags: FLAG_NOT_LIVE | flags,
        };
        encode(&moment, fingers)
    }
}

/// Frames of a film for one page.
pub struct Projector<F> {
    film: F,
    fingers: Vec<usize>,
    objects: Vec<String>,
    heard: Heard,
}

/// Statuses of the task's pictures some time before a moment, with that time.
pub type Heard = Box<dyn Fn(f64) -> Option<(f64, Story)>>;

impl<F: Film> Projector<F> {
    /// Shows `film`; `fingers` as in [`crate::scene::fingers`], `objects` by their
    /// place in the cell file.
    pub fn new(film: F, fingers: Vec<usize>, objects: Vec<String>, heard: Heard) -> Self {
        Self {
            film,
            fingers,
            objects,
            heard,
        }
    }

    /// The task's pictures at `time_s`, as far as known.
    fn story(&mut self, time_s: f64) -> Story {
        let heard = (self.heard)(time_s);
        let (from_s, mut story) = heard.unwrap_or_else(|| (time_s - PICTURES_S, Story::default()));
        // From the last known statuses on; without them the last second has every picture.
        for line in self.film.trace(from_s, time_s).unwrap_or_default() {
            story.take_picture(&line);
        }
        story
    }
}

impl<F: Film> Past for Projector<F> {
    fn frame(&mut self, when: When) -> Result<Vec<u8>, String> {
        let time_s = when.time_s;
        self.film.show_epoch(when.epoch);
        let (from_s, to_s) = self.film.span_s();
        // Checked, as the caller opens the recording again if it has grown.
        if !(from_s..=to_s).contains(&time_s) {
            let span = format!("from {from_s:.1} s to {to_s:.1} s");
            return Err(format!("{time_s:.1} s is not recorded; there is {span}"));
        }
        Ok(self.film.still(time_s)?.frame(&self.fingers, 0.0, 0))
    }

    fn told(&mut self, when: When) -> Value {
        let time_s = when.time_s;
        self.film.show_epoch(when.epoch);
        let story = self.story(time_s);
        let still = self.film.still(time_s).ok();
        let mut told = status::past(&StatusInput {
            processes: &[],
            missed: &[],
            world: still.as_ref().map(|still| still.world.as_ref()),
            decision: still.as_ref().map(|still| still.decision.as_ref()),
            objects: &self.objects,
            breaks: &[],
            policy: "",
        });
        told["t"] = json!("past");
        told["time_s"] = json!(time_s);
        told["epoch"] = json!(when.epoch);
        told["story"] = json!(story.picture());
        told
    }

    fn frames(&mut self, span: &Span) -> Result<Vec<u8>, String> {
        self.film.show_epoch(span.epoch);
        let (from_s, to_s) = self.film.span_s();
        let (mut frames, mut last) = (Vec::new(), None);
        for time_s in span.times_s().filter(|at| (from_s..=to_s).contains(at)) {
            // At the start of a recording there may be no complete state yet.
            let Ok(still) = self.film.still(time_s) else {
                continue;
            };
            // A paused cell has one state for many times; it is sent once.
            if last.replace(still.world.header.tick) != Some(still.world.header.tick) {
                frames.extend(still.frame(&self.fingers, 0.0, 0));
            }
        }
        Ok(frames)
    }
}

impl Film for cell_record::Recording {
    fn show_epoch(&mut self, epoch: Option<u32>) {
        Self::show_epoch(self, epoch);
    }

    fn span_s(&self) -> (f64, f64) {
        Self::span_s(self)
    }

    fn still(&mut self, time_s: f64) -> Result<Still, String> {
        let frame = self.at(time_s).map_err(|error| error.to_string())?;
        Ok(Still {
            world: frame.world,
            status: frame.status,
            decision: frame.decision,
        })
    }

    fn trace(&mut self, from_s: f64, to_s: f64) -> Result<Vec<TraceLine>, String> {
        Self::trace(self, from_s, to_s).map_err(|error| error.to_string())
    }

    fn log_until(&mut self, time_s: f64, count: usize) -> Result<Vec<TraceLine>, String> {
        Self::log_until(self, time_s, count).map_err(|error| error.to_string())
    }
}
