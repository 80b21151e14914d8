//! Another time of the run for one client: frames of the recording.

use std::io;
use std::sync::Arc;
use std::sync::mpsc;

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use serde::Deserialize;
use serde_json::Value;
use tokio::sync::watch;

use crate::page::desk::{Answer, Reply, send};

/// A moment of the run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct When {
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
pub struct Span {
    /// The first (simulated s).
    pub from_s: f64,
    /// The last (simulated s).
    pub to_s: f64,
    /// Generation of physics; the newest without one.
    pub epoch: Option<u32>,
    /// How many.
    pub count: u32,
}

impl Span {
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
pub trait Past {
    /// The frame of the newest state at or before `when`.
    ///
    /// # Errors
    ///
    /// The reason, for people.
    fn frame(&mut self, when: When) -> Result<Vec<u8>, String>;

    /// State of task and equipment at that time (`past` of docs/page-protocol.md).
    fn told(&mut self, when: When) -> Value;

    /// The frames of `span`, one after the other.
    ///
    /// # Errors
    ///
    /// The reason, for people.
    fn frames(&mut self, span: &Span) -> Result<Vec<u8>, String>;
}

/// A moment of the past for one page; empty before the first.
#[derive(Clone, Debug, Default)]
pub struct Glimpse {
    /// The frame.
    pub frame: Bytes,
    /// The messages of that moment.
    pub told: Utf8Bytes,
}

/// Opens the recording as it is now.
pub type OpenPast = Arc<dyn Fn() -> Result<Box<dyn Past>, String> + Send + Sync>;

/// Shows the past on its own thread, which ends when this is dropped.
pub struct Scrubber {
    times: mpsc::Sender<(When, Answer)>,
    glimpses: watch::Receiver<Glimpse>,
}

impl Scrubber {
    /// Starts the thread.
    ///
    /// # Errors
    ///
    /// When no thread can be created.
    pub fn start(open: OpenPast) -> io::Result<Self> {
        let (times, wanted) = mpsc::channel();
        let (shown, glimpses) = watch::channel(Glimpse::default());
        let work = move || look(&open, &wanted, &shown);
        // A thread, as reading blocks: the others are served by one thread.
        std::thread::Builder::new()
            .name("scrub".to_owned())
            .spawn(work)?;
        Ok(Self { times, glimpses })
    }

    /// Shows `when` next.
    pub fn seek(&self, when: When, answer: Answer) {
        if let Err(mpsc::SendError((_, answer))) = self.times.send((when, answer)) {
            send(
                answer,
                Reply::refused("the recording cannot be read any more"),
            );
        }
    }

    /// Receiver of the moments.
    pub fn glimpses(&self) -> watch::Receiver<Glimpse> {
        self.glimpses.clone()
    }
}

fn look(open: &OpenPast, wanted: &mpsc::Receiver<(When, Answer)>, shown: &watch::Sender<Glimpse>) {
    let mut past = None;
    while let Ok((mut when, mut answer)) = wanted.recv() {
        // A person dragging a slider requests more times than can be shown.
        while let Ok((later, newer)) = wanted.try_recv() {
            // Answered all the same: each request of a page waits for its answer.
            send(answer, Reply::done());
            (when, answer) = (later, newer);
        }
        let reply = match glimpse(open, &mut past, when) {
            Ok(glimpse) => {
                shown.send_replace(glimpse);
                Reply::done()
            }
            Err(why) => Reply::refused(why),
        };
        send(answer, reply);
    }
}

/// The open recording may have lost its start, or lack the end: then it is opened again, once.
fn glimpse(
    open: &OpenPast,
    past: &mut Option<Box<dyn Past>>,
    when: When,
) -> Result<Glimpse, String> {
    let of = |past: &mut Box<dyn Past>, frame: Vec<u8>| Glimpse {
        frame: Bytes::from(frame),
        told: Utf8Bytes::from(past.told(when).to_string()),
    };
    if let Some(known) = past
        && let Ok(frame) = known.frame(when)
    {
        return Ok(of(known, frame));
    }
    let opened = past.insert(open()?);
    let frame = opened.frame(when)?;
    Ok(of(opened, frame))
}
