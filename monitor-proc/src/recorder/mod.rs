//! The recorder: all messages into a ring of files and, on request, into a file that is kept.
//! It has its own thread and its own bus: a slow disk slows down no other process (ADR 0012).

mod assembler;
mod batch;
mod hops;
mod latency;
mod progress;
mod report;
mod sink;
mod socket;
mod taps;
mod thread;

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

use crate::feed::broadcast::RecordedSpan;
pub use latency::HopLatency;

/// Time in which the recorder answers, unless the disk hangs.
const PATIENCE: Duration = Duration::from_secs(10);
/// Name of the socket in the run directory.
const SOCKET: &str = "record.sock";

/// Requests to the recorder.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub enum RecorderRequest {
    /// Record everything from now on in a new file.
    Start {
        /// The file.
        file: PathBuf,
    },
    /// Close that file.
    Stop,
    /// Write the newest part of the ring to a new file.
    Last {
        /// Length (simulated s).
        seconds: f64,
        /// The file.
        file: PathBuf,
    },
    /// Write the messages still in memory to the disk.
    Flush,
}

/// Status of the recorder.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RecorderStatus {
    /// `on`, `off` or `trouble`.
    pub state: &'static str,
    /// Bytes of the ring.
    pub bytes: u64,
    /// Bytes it may have.
    pub limit_bytes: u64,
    /// The file being recorded.
    pub file: Option<String>,
    /// Messages that were not recorded.
    pub gaps: u64,
    /// The current problem; empty for none.
    pub note: String,
    /// Simulated time in the ring.
    #[serde(skip)]
    pub recorded_span: RecordedSpan,
}

type Answer = mpsc::Sender<Result<String, String>>;
type QueuedRequest = (RecorderRequest, Answer);

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
    client: Option<RecorderClient>,
    page: mpsc::Sender<Value>,
    threads: Vec<JoinHandle<()>>,
    socket: PathBuf,
}

/// Sends requests to the thread of the recorder.
#[derive(Clone)]
struct RecorderClient {
    requests: mpsc::Sender<QueuedRequest>,
    shared: Arc<Shared>,
    flight_dir: PathBuf,
}

impl Recorder {
    /// Starts the recorder of the run of `start`, whose page shows `scene`. Errors are reported
    /// by [`Recorder::status`] and do not stop the caller.
    pub fn start(start: &Start, scene: Value) -> Self {
        let shared = Arc::new(Shared::default());
        let (requests, received) = mpsc::channel();
        let (page, page_messages) = mpsc::channel();
        let client = RecorderClient {
            requests,
            shared: shared.clone(),
            flight_dir: start.spec.record.flight_dir.clone(),
        };
        let socket = start.spec.run_dir.join(SOCKET);
        let job = thread::Job {
            spec: start.spec.clone(),
            generation: start.generation,
            scene,
            shared: shared.clone(),
            requests: received,
            page: page_messages,
        };
        let mut recorder = Self {
            shared,
            client: Some(client.clone()),
            page,
            threads: Vec::new(),
            socket: socket.clone(),
        };
        // The recorder before its socket: a request must find it.
        recorder.spawn("recorder", move || thread::run(&job));
        recorder.spawn("record-socket", move || socket::serve(&socket, &client));
        recorder
    }

    /// Records a message of the channel `page` (docs/recording.md).
    pub fn record_page(&self, message: Value) {
        // Without its thread nothing is recorded, which the status reports.
        let _taken = self.page.send(message).is_ok();
    }

    /// Its status.
    pub fn status(&self) -> RecorderStatus {
        lock(&self.shared.status).clone()
    }

    /// Latency of the last five to ten seconds, hop by hop.
    pub fn latency(&self) -> Vec<HopLatency> {
        lock(&self.shared.latency).clone()
    }

    /// Sends a request and waits for the answer; copying the last minutes takes seconds, on the
    /// thread of the caller.
    ///
    /// # Errors
    ///
    /// The reason, for people.
    pub fn ask(&self, request: RecorderRequest) -> Result<String, String> {
        match &self.client {
            Some(client) => client.ask(request),
            None => Err("the recorder is ending".to_owned()),
        }
    }

    fn spawn(&mut self, name: &str, work: impl FnOnce() + Send + 'static) {
        let thread = std::thread::Builder::new().name(name.to_owned());
        match thread.spawn(work) {
            Ok(thread) => self.threads.push(thread),
            // No thread, no recording, but a cell: the status reports it.
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
        // In this order: the flag, then no more requests, then the
        // socket's thread is woken to see both.
        self.shared.ending.store(true, Ordering::Release);
        self.client = None;
        socket::wake(&self.socket);
        for thread in self.threads.drain(..) {
            // Its errors are reported already.
            let _ended = thread.join().is_ok();
        }
    }
}

impl RecorderClient {
    // Copied on the caller's thread from the files: recording continues meanwhile.
    fn ask(&self, request: RecorderRequest) -> Result<String, String> {
        let RecorderRequest::Last { seconds, file } = request else {
            return self.pass_on(request);
        };
        // Written so that NaN is refused, too.
        if !(seconds > 0.0) {
            return Err(format!("{seconds} s; give more than 0"));
        }
        // The newest second may be in memory only.
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
        self.requests.send((request, answer)).map_err(gone)?;
        answered
            .recv_timeout(PATIENCE)
            .map_err(|_| "the recorder does not answer: its disk may be slow".to_owned())?
    }
}
