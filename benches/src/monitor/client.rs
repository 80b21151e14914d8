//! Clients of the page: a normal viewer, and some that flood it.

use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use cell_rt::clock::monotonic_ns;
use serde_json::{Value, json};
use tungstenite::{ClientRequestBuilder, Message, WebSocket};

/// Interval of the commands.
// 50 a second, near what a page sends while a person drags.
const EVERY_NS: u64 = 20_000_000;

/// Receives frames, and if requested sends commands without effect.
pub(crate) struct Viewer {
    stop: Arc<AtomicBool>,
    frames: Arc<AtomicU64>,
    thread: JoinHandle<Vec<u64>>,
}

impl Viewer {
    /// Starts it; `asks`: whether it sends commands as well.
    pub(crate) fn start(address: SocketAddr, token: String, asks: bool) -> Self {
        let (stop, frames) = (Arc::new(AtomicBool::new(false)), Arc::default());
        let thread = std::thread::spawn({
            let (stop, frames) = (Arc::clone(&stop), Arc::clone(&frames));
            move || watch(address, &token, asks, (&stop, &frames))
        });
        Self {
            stop,
            frames,
            thread,
        }
    }

    pub(crate) fn frames(&self) -> u64 {
        self.frames.load(Ordering::Relaxed)
    }

    /// Round trips (ns), and the number of frames received.
    pub(crate) fn stop(self) -> (Vec<u64>, u64) {
        self.stop.store(true, Ordering::Relaxed);
        let frames = Arc::clone(&self.frames);
        let trips = self.thread.join().unwrap_or_default();
        (trips, frames.load(Ordering::Relaxed))
    }
}

fn watch(
    address: SocketAddr,
    token: &str,
    asks: bool,
    (stop, frames): (&AtomicBool, &AtomicU64),
) -> Vec<u64> {
    let mut trips = Vec::new();
    let Some(mut socket) = connect(address, token) else {
        return trips;
    };
    let (mut id, mut sent_ns) = (0_u64, 0);
    while !stop.load(Ordering::Relaxed) {
        let now = monotonic_ns();
        if asks && now - sent_ns > EVERY_NS {
            id += 1;
            sent_ns = now;
            // The cell is running already: physics accepts it, and nothing changes.
            let ask = json!({"id": id, "do": "resume"}).to_string();
            if socket.send(Message::text(ask)).is_err() {
                return trips;
            }
        }
        match socket.read() {
            Ok(Message::Binary(_)) => {
                frames.fetch_add(1, Ordering::Relaxed);
            }
            Ok(Message::Text(text)) if text.contains("\"ack\"") => {
                let answer: Value = serde_json::from_str(&text).unwrap_or_default();
                // Only the answer to the newest command: older ones were already late.
                if answer["id"] == json!(id) && answer["ok"] == json!(true) {
                    trips.push(monotonic_ns() - sent_ns);
                }
            }
            Ok(_) => {}
            Err(_) => return trips,
        }
    }
    trips
}

/// Sends as much as it can, and connects again when it was disconnected.
pub(crate) struct Flood {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<u64>,
}

impl Flood {
    /// Floods while `on` is set.
    pub(crate) fn start(address: SocketAddr, token: String, on: Arc<AtomicBool>) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let thread = std::thread::spawn({
            let stop = Arc::clone(&stop);
            move || flood(address, &token, &stop, &on)
        });
        Self { stop, thread }
    }

    /// Number of disconnections.
    pub(crate) fn stop(self) -> u64 {
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap_or_default()
    }
}

fn flood(address: SocketAddr, token: &str, stop: &AtomicBool, on: &AtomicBool) -> u64 {
    let mut closed = 0;
    let mut socket = None;
    while !stop.load(Ordering::Relaxed) {
        if !on.load(Ordering::Relaxed) {
            // Disconnected between the blocks: an open idle
            // connection would cost the monitor as well.
            socket = None;
            std::thread::sleep(Duration::from_millis(5));
            continue;
        }
        if socket.is_none() {
            socket = connect(address, token);
        }
        let ask = Message::text(r#"{"id": 1, "do": "again"}"#);
        let sent = socket.as_mut().is_some_and(|s| s.send(ask).is_ok());
        if !sent {
            closed += 1;
            socket = None;
            std::thread::sleep(Duration::from_millis(1));
        }
    }
    closed
}

fn connect(address: SocketAddr, token: &str) -> Option<WebSocket<TcpStream>> {
    let stream = TcpStream::connect_timeout(&address, Duration::from_secs(1)).ok()?;
    stream.set_nodelay(true).ok()?;
    // With a limit: a page that hangs must not hang the bench.
    stream.set_read_timeout(Some(Duration::from_secs(2))).ok()?;
    stream
        .set_write_timeout(Some(Duration::from_secs(1)))
        .ok()?;
    let uri = format!("ws://{address}/ws").parse().ok()?;
    let request =
        ClientRequestBuilder::new(uri).with_header("Authorization", format!("Bearer {token}"));
    let (socket, _) = tungstenite::client(request, stream).ok()?;
    Some(socket)
}
