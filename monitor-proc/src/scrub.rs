//! Another time of the run for one client: frames of what was recorded.

use std::io;
use std::sync::Arc;
use std::sync::mpsc;

use axum::body::Bytes;
use axum::extract::ws::Utf8Bytes;
use serde_json::Value;
use tokio::sync::watch;

use crate::page::desk::{Answer, Reply, send};

/// What was recorded. Made and used on one thread.
pub trait Past {
    /// The frame of the newest state at or before `time_s`.
    ///
    /// # Errors
    ///
    /// Why there is none, for people.
    fn frame(&mut self, time_s: f64) -> Result<Vec<u8>, String>;

    /// What task and equipment said then (`past` of docs/page-protocol.md).
    fn told(&mut self, time_s: f64) -> Value;
}

/// A moment of the past for one page; empty before the first.
#[derive(Clone, Debug, Default)]
pub struct Glimpse {
    /// The frame.
    pub frame: Bytes,
    /// What was said.
    pub told: Utf8Bytes,
}

/// Opens what was recorded up to now.
pub type OpenPast = Arc<dyn Fn() -> Result<Box<dyn Past>, String> + Send + Sync>;

/// Looks into the past on a thread of its own, which ends with this.
pub struct Scrubber {
    times: mpsc::Sender<(f64, Answer)>,
    glimpses: watch::Receiver<Glimpse>,
}

impl Scrubber {
    /// Starts the thread.
    ///
    /// # Errors
    ///
    /// When there can be no other thread.
    pub fn start(open: OpenPast) -> io::Result<Self> {
        let (times, wanted) = mpsc::channel();
        let (shown, glimpses) = watch::channel(Glimpse::default());
        let work = move || look(&open, &wanted, &shown);
        std::thread::Builder::new()
            .name("scrub".to_owned())
            .spawn(work)?;
        Ok(Self { times, glimpses })
    }

    /// Shows `time_s` next.
    pub fn seek(&self, time_s: f64, answer: Answer) {
        if let Err(mpsc::SendError((_, answer))) = self.times.send((time_s, answer)) {
            send(
                answer,
                Reply::refused("the recording cannot be read any more"),
            );
        }
    }

    /// Where the moments come out.
    pub fn glimpses(&self) -> watch::Receiver<Glimpse> {
        self.glimpses.clone()
    }
}

fn look(open: &OpenPast, wanted: &mpsc::Receiver<(f64, Answer)>, shown: &watch::Sender<Glimpse>) {
    let mut past = None;
    while let Ok((mut time_s, mut answer)) = wanted.recv() {
        // A hand that drags a slider asks for more times than can be shown.
        while let Ok((newer_s, newer)) = wanted.try_recv() {
            send(answer, Reply::done());
            (time_s, answer) = (newer_s, newer);
        }
        let reply = match glimpse(open, &mut past, time_s) {
            Ok(glimpse) => {
                shown.send_replace(glimpse);
                Reply::done()
            }
            Err(why) => Reply::refused(why),
        };
        send(answer, reply);
    }
}

/// What is open may have lost its beginning, or not have the end: then it is
/// opened anew, once.
fn glimpse(
    open: &OpenPast,
    past: &mut Option<Box<dyn Past>>,
    time_s: f64,
) -> Result<Glimpse, String> {
    let of = |past: &mut Box<dyn Past>, frame: Vec<u8>| Glimpse {
        frame: Bytes::from(frame),
        told: Utf8Bytes::from(past.told(time_s).to_string()),
    };
    if let Some(known) = past
        && let Ok(frame) = known.frame(time_s)
    {
        return Ok(of(known, frame));
    }
    let opened = past.insert(open()?);
    let frame = opened.frame(time_s)?;
    Ok(of(opened, frame))
}
