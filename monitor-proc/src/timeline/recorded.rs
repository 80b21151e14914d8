//! A recording as a source of states and of another time for a page.

use ipc_types::{ArmStatus, Decision, TraceLine, WorldState};
use serde_json::{Value, json};

use crate::feed::snapshot::{FLAG_NOT_LIVE, Snapshot, encode};
use crate::feed::status::{self, StatusInput};
use crate::timeline::scrub::{PastReader, PastSpan, SeekTarget};
use crate::trace::TraceModel;

/// Statuses and pictures of the task are in the trace once a second: this much of it has all.
const REPEAT_S: f64 = 1.1;

/// One moment of a recording.
#[derive(Clone, Debug)]
pub struct RecordedState {
    /// The world.
    pub world: Box<WorldState>,
    /// Status of the controllers.
    pub status: Vec<ArmStatus>,
    /// Decision of the task.
    pub decision: Box<Decision>,
}

/// A recording that can be read.
pub trait RecordingSource {
    /// Shows the history of `epoch` from now on, or of the newest.
    fn show_epoch(&mut self, epoch: Option<u32>);

    /// First and last moment of that history (simulated seconds).
    fn span_s(&self) -> (f64, f64);

    /// The newest moment at or before `time_s`.
    ///
    /// # Errors
    ///
    /// The reason why there is none.
    fn state_at(&mut self, time_s: f64) -> Result<RecordedState, String>;

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

impl RecordedState {
    /// The frame of this moment.
    pub fn frame(&self, fingers: &[usize], real_time_factor: f64, flags: u32) -> Vec<u8> {
        // Each status names its arm.
        let of = |arm: usize| self.status.iter().find(|s| s.arm as usize == arm);
        let status: Vec<Option<&ArmStatus>> = (0..self.world.arms().len()).map(of).collect();
        let snapshot = Snapshot {
            world: &self.world,
            status: &status,
            decision: Some(&self.decision),
            // Contacts are not recorded.
            contacts: None,
            real_time_factor,
            flags: FLAG_NOT_LIVE | flags,
        };
        encode(&snapshot, fingers)
    }
}

/// Another time of a recording for one page.
pub struct RecordedPast<F> {
    recording: F,
    fingers: Vec<usize>,
    objects: Vec<String>,
    before: TraceBefore,
}

/// Statuses of the task's pictures some time before a moment, with that time.
pub type TraceBefore = Box<dyn Fn(f64) -> Option<(f64, TraceModel)>>;

impl<F: RecordingSource> RecordedPast<F> {
    /// Shows `recording`; `fingers` as in [`crate::feed::scene::fingers`], `objects` by their
    /// place in the cell file.
    pub fn new(
        recording: F,
        fingers: Vec<usize>,
        objects: Vec<String>,
        before: TraceBefore,
    ) -> Self {
        Self {
            recording,
            fingers,
            objects,
            before,
        }
    }

    /// The task's pictures at `time_s`, as far as known.
    fn trace_at(&mut self, time_s: f64) -> TraceModel {
        let before = (self.before)(time_s);
        let (from_s, mut trace) =
            before.unwrap_or_else(|| (time_s - REPEAT_S, TraceModel::default()));
        // From the last known statuses on; without them the last second has every picture.
        for line in self.recording.trace(from_s, time_s).unwrap_or_default() {
            trace.take_picture(&line);
        }
        trace
    }
}

impl<F: RecordingSource> PastReader for RecordedPast<F> {
    fn frame(&mut self, target: SeekTarget) -> Result<Vec<u8>, String> {
        let time_s = target.time_s;
        self.recording.show_epoch(target.epoch);
        let (from_s, to_s) = self.recording.span_s();
        // Checked, as the caller opens the recording again if it has grown.
        if !(from_s..=to_s).contains(&time_s) {
            let span = format!("from {from_s:.1} s to {to_s:.1} s");
            return Err(format!("{time_s:.1} s is not recorded; there is {span}"));
        }
        let state = self.recording.state_at(time_s)?;
        Ok(state.frame(&self.fingers, 0.0, 0))
    }

    fn message(&mut self, target: SeekTarget) -> Value {
        let time_s = target.time_s;
        self.recording.show_epoch(target.epoch);
        let trace = self.trace_at(time_s);
        let state = self.recording.state_at(time_s).ok();
        let mut message = status::past(&StatusInput {
            processes: &[],
            missed: &[],
            world: state.as_ref().map(|state| state.world.as_ref()),
            decision: state.as_ref().map(|state| state.decision.as_ref()),
            objects: &self.objects,
            breaks: &[],
            policy: "",
        });
        message["t"] = json!("past");
        message["time_s"] = json!(time_s);
        message["epoch"] = json!(target.epoch);
        message["story"] = json!(trace.pictures_state());
        message
    }

    fn frames(&mut self, span: &PastSpan) -> Result<Vec<u8>, String> {
        self.recording.show_epoch(span.epoch);
        let (from_s, to_s) = self.recording.span_s();
        let (mut frames, mut last) = (Vec::new(), None);
        for time_s in span.times_s().filter(|at| (from_s..=to_s).contains(at)) {
            // At the start of a recording there may be no complete state yet.
            let Ok(state) = self.recording.state_at(time_s) else {
                continue;
            };
            // A paused cell has one state for many times; it is sent once.
            if last.replace(state.world.header.tick) != Some(state.world.header.tick) {
                frames.extend(state.frame(&self.fingers, 0.0, 0));
            }
        }
        Ok(frames)
    }
}

impl RecordingSource for cell_record::Recording {
    fn show_epoch(&mut self, epoch: Option<u32>) {
        Self::show_epoch(self, epoch);
    }

    fn span_s(&self) -> (f64, f64) {
        Self::span_s(self)
    }

    fn state_at(&mut self, time_s: f64) -> Result<RecordedState, String> {
        let frame = self.at(time_s).map_err(|error| error.to_string())?;
        Ok(RecordedState {
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
