//! Another time of the run for one client: frames of the recording.

use std::io;
use std::sync::Arc;
use std::sync::mpsc;

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use serde::Deserialize;
use serde_json::Value;
use tokio::sync::watch;

use crate::page::queue::{Answer, Reply, send};

/// A moment of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SeekTarget {
    /// Generation of physics whose history is shown; the newest by default.
    pub epoch: Option<u32>,
    /// Simulated time (s).
    pub time_s: f64,
}

/// Longest span that is read at once (s).
// The ring holds about ten minutes.
const MAX_SPAN_S: f64 = 600.0;
/// Largest number of frames that is read at once.
const MAX_FRAMES: u32 = 1000;

/// Equally spaced moments of the run.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
pub struct PastSpan {
    /// The first (simulated s).
    pub from_s: f64,
    /// The last (simulated s).
    pub to_s: f64,
    /// Generation of physics; the newest without one.
    pub epoch: Option<u32>,
    /// How many.
    pub count: u32,
}

impl PastSpan {
    /// Whether it can be read at once.
    pub fn is_valid(&self) -> bool {
        // The count is at least 2, so the division by one less is safe.
        let length_s = self.to_s - self.from_s;
        (2..=MAX_FRAMES).contains(&self.count) && (0.0..=MAX_SPAN_S).contains(&length_s)
    }

    /// Its moments (simulated s).
    pub fn times_s(&self) -> impl Iterator<Item = f64> {
        let step_s = (self.to_s - self.from_s) / f64::from(self.count - 1);
        (0..self.count).map(move |at| self.from_s + step_s * f64::from(at))
    }
}

/// A recording. Created and used on one thread.
pub trait PastReader {
    /// The frame of the newest state at or before `target`.
    ///
    /// # Errors
    ///
    /// The reason, for people.
    fn frame(&mut self, target: SeekTarget) -> Result<Vec<u8>, String>;

    /// State of task and equipment at that time (`past` of docs/page-protocol.md).
    fn message(&mut self, target: SeekTarget) -> Value;

    /// The frames of `span`, one after the other.
    ///
    /// # Errors
    ///
    /// The reason, for people.
    fn frames(&mut self, span: &PastSpan) -> Result<Vec<u8>, String>;
}

/// A moment of the past for one page; empty before the first.
#[derive(Clone, Debug, Default)]
pub struct PastMoment {
    /// The frame.
    pub frame: Bytes,
    /// The messages of that moment.
    pub message: Utf8Bytes,
}

/// Opens the recording as it is now.
pub type OpenPast = Arc<dyn Fn() -> Result<Box<dyn PastReader>, String> + Send + Sync>;

/// Shows the past on its own thread, which ends when this is dropped.
pub struct Scrubber {
    targets: mpsc::Sender<(SeekTarget, Answer)>,
    moments: watch::Receiver<PastMoment>,
}

impl Scrubber {
    /// Starts the thread.
    ///
    /// # Errors
    ///
    /// When no thread can be created.
    pub fn start(open: OpenPast) -> io::Result<Self> {
        let (targets, wanted) = mpsc::channel();
        let (shown, moments) = watch::channel(PastMoment::default());
        let work = move || show_moments(&open, &wanted, &shown);
        // A thread, as reading blocks: the others are served by one thread.
        std::thread::Builder::new()
            .name("scrub".to_owned())
            .spawn(work)?;
        Ok(Self { targets, moments })
    }

    /// Shows `target` next.
    pub fn seek(&self, target: SeekTarget, answer: Answer) {
        if let Err(mpsc::SendError((_, answer))) = self.targets.send((target, answer)) {
            send(
                answer,
                Reply::refused("the recording cannot be read any more"),
            );
        }
    }

    /// Receiver of the moments.
    pub fn moments(&self) -> watch::Receiver<PastMoment> {
        self.moments.clone()
    }
}

fn show_moments(
    open: &OpenPast,
    wanted: &mpsc::Receiver<(SeekTarget, Answer)>,
    shown: &watch::Sender<PastMoment>,
) {
    let mut past = None;
    while let Ok((mut target, mut answer)) = wanted.recv() {
        // A person dragging a slider requests more times than can be shown.
        while let Ok((later, newer)) = wanted.try_recv() {
            // Answered all the same: each request of a page waits for its answer.
            send(answer, Reply::done());
            (target, answer) = (later, newer);
        }
        let reply = match moment(open, &mut past, target) {
            Ok(moment) => {
                shown.send_replace(moment);
                Reply::done()
            }
            Err(why) => Reply::refused(why),
        };
        send(answer, reply);
    }
}

/// The open recording may have lost its start, or lack the end: then it is opened again, once.
fn moment(
    open: &OpenPast,
    past: &mut Option<Box<dyn PastReader>>,
    target: SeekTarget,
) -> Result<PastMoment, String> {
    let of = |past: &mut Box<dyn PastReader>, frame: Vec<u8>| PastMoment {
        frame: Bytes::from(frame),
        message: Utf8Bytes::from(past.message(target).to_string()),
    };
    if let Some(known) = past
        && let Ok(frame) = known.frame(target)
    {
        return Ok(of(known, frame));
    }
    let opened = past.insert(open()?);
    let frame = opened.frame(target)?;
    Ok(of(opened, frame))
}
