//! The recorder: everything that was said, into a ring of files and, on
//! request, into a file that is kept. A thread of its own with its own bus: a
//! slow disk slows no other process.

mod batch;
mod hops;
mod latency;
mod progress;
mod report;
mod sink;
mod socket;
mod taps;
mod thread;
mod whole;

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use cell_record::Recording;
use cell_worker::Start;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::hub::Timeline;
pub use latency::HopLatency;

/// The recorder answers within this, unless the disk stands still.
const PATIENCE: Duration = Duration::from_secs(10);
/// Name of the socket in the run directory.
const SOCKET: &str = "record.sock";

/// What the recorder shall do.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub enum RecorderRequest {
    /// Keep all from now on, in a new file.
    Start {
        /// The file.
        file: PathBuf,
    },
    /// Close that file.
    Stop,
    /// Write the newest part of the ring to a new file.
    Last {
        /// How much (simulated s).
        seconds: f64,
        /// The file.
        file: PathBuf,
    },
    /// Write down what is still in memory.
    Flush,
}

/// How the recorder is doing.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RecorderStatus {
    /// `on`, `off` or `trouble`.
    pub state: &'static str,
    /// Bytes of the ring.
    pub bytes: u64,
    /// Bytes it may have.
    pub limit_bytes: u64,
    /// The file that is being kept.
    pub file: Option<String>,
    /// Messages that were not recorded.
    pub gaps: u64,
    /// What is wrong; empty for nothing.
    pub note: String,
    /// Simulated time in the ring.
    #[serde(skip)]
    pub timeline: Timeline,
}

type Answer = mpsc::Sender<Result<String, String>>;
type Ask = (RecorderRequest, Answer);

#[derive(Default)]
struct Shared {
    status: Mutex<RecorderStatus>,
    latency: Mutex<Vec<HopLatency>>,
    ending: AtomicBool,
}

fn lock<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The recorder of a live cell; ends when dropped.
pub struct Recorder {
    shared: Arc<Shared>,
    desk: Option<Desk>,
    threads: Vec<JoinHandle<()>>,
    socket: PathBuf,
}

/// Where requests are handed in.
#[derive(Clone)]
struct Desk {
    asks: mpsc::Sender<Ask>,
    shared: Arc<Shared>,
    flight_dir: PathBuf,
}

impl Recorder {
    /// Starts the recorder of the run of `start`, whose page shows `scene`.
    /// What fails is in [`Recorder::status`], not in the way.
    pub fn start(start: &Start, scene: Value) -> Self {
        let shared = Arc::new(Shared::default());
        let (asks, asked) = mpsc::channel();
        let desk = Desk {
            asks,
            shared: shared.clone(),
            flight_dir: start.spec.record.flight_dir.clone(),
        };
        let socket = start.spec.run_dir.join(SOCKET);
        let job = thread::Job {
            spec: start.spec.clone(),
            generation: start.generation,
            scene,
            shared: shared.clone(),
            asked,
        };
        let mut recorder = Self {
            shared,
            desk: Some(desk.clone()),
            threads: Vec::new(),
            socket: socket.clone(),
        };
        recorder.spawn("recorder", move || thread::run(&job));
        recorder.spawn("record-socket", move || socket::serve(&socket, &desk));
        recorder
    }

    /// How it is doing.
    pub fn status(&self) -> RecorderStatus {
        lock(&self.shared.status).clone()
    }

    /// Latency of the last five to ten seconds, hop by hop.
    pub fn latency(&self) -> Vec<HopLatency> {
        lock(&self.shared.latency).clone()
    }

    /// Asks for something and waits for it; copying the last minutes takes
    /// seconds, on the thread of the caller.
    ///
    /// # Errors
    ///
    /// Why not, for people.
    pub fn ask(&self, request: RecorderRequest) -> Result<String, String> {
        match &self.desk {
            Some(desk) => desk.ask(request),
            None => Err("the recorder is ending".to_owned()),
        }
    }

    fn spawn(&mut self, name: &str, work: impl FnOnce() + Send + 'static) {
        let thread = std::thread::Builder::new().name(name.to_owned());
        match thread.spawn(work) {
            Ok(thread) => self.threads.push(thread),
            Err(error) => {
                let mut status = lock(&self.shared.status);
                status.state = "trouble";
                status.note = format!("no thread for the recorder: {error}");
            }
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.shared.ending.store(true, Ordering::Release);
        self.desk = None;
        socket::wake(&self.socket);
        for thread in self.threads.drain(..) {
            // It has said what was wrong with it already.
            let _ended = thread.join().is_ok();
        }
    }
}

impl Desk {
    fn ask(&self, request: RecorderRequest) -> Result<String, String> {
        let RecorderRequest::Last { seconds, file } = request else {
            return self.pass_on(request);
        };
        if !(seconds > 0.0) {
            return Err(format!("{seconds} s; give more than 0"));
        }
        self.pass_on(RecorderRequest::Flush)?;
        let text = |error: cell_record::RecordError| error.to_string();
        let ring = Recording::open(&self.flight_dir).map_err(text)?;
        let (begin_s, to_s) = ring.span_s();
        let from_s = (to_s - seconds).max(begin_s);
        let copied = ring.copy_span(from_s, to_s, &file).map_err(text)?;
        let missing = match copied.missing {
            0 => String::new(),
            count => format!(", {count} messages missing (its channel `gaps` has their times)"),
        };
        Ok(format!(
            "{}: {from_s:.1} s to {to_s:.1} s, {:.1} MB{missing}",
            file.display(),
            copied.bytes as f64 / 1.0e6
        ))
    }

    fn pass_on(&self, request: RecorderRequest) -> Result<String, String> {
        let (answer, answered) = mpsc::channel();
        let gone = |_| "the recorder is ending".to_owned();
        self.asks.send((request, answer)).map_err(gone)?;
        answered
            .recv_timeout(PATIENCE)
            .map_err(|_| "the recorder does not answer: its disk may be slow".to_owned())?
    }
}
