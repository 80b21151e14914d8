//! Programs that look at the page: one that behaves, and those that do not.

use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use cell_rt::clock::monotonic_ns;
use serde_json::{Value, json};
use tungstenite::{ClientRequestBuilder, Message, WebSocket};

/// A command this often.
const EVERY_NS: u64 = 20_000_000;

/// Looks, and asks for what changes nothing where it is told to.
pub(crate) struct Viewer {
    stop: Arc<AtomicBool>,
    frames: Arc<AtomicU64>,
    thread: JoinHandle<Vec<u64>>,
}

impl Viewer {
    /// Begins; `asks` says whether it sends commands, too.
    pub(crate) fn start(address: SocketAddr, token: String, asks: bool) -> Self {
        let (stop, frames) = (Arc::new(AtomicBool::new(false)), Arc::default());
        let thread = std::thread::spawn({
            let (stop, frames) = (Arc::clone(&stop), Arc::clone(&frames));
            move || look(address, &token, asks, (&stop, &frames))
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

    /// Round trips (ns), and frames seen.
    pub(crate) fn stop(self) -> (Vec<u64>, u64) {
        self.stop.store(true, Ordering::Relaxed);
        let frames = Arc::clone(&self.frames);
        let trips = self.thread.join().unwrap_or_default();
        (trips, frames.load(Ordering::Relaxed))
    }
}

fn look(
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
            // The cell runs already: physics takes it, and nothing changes.
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

/// Sends as much as it can, and comes back when it was thrown out.
pub(crate) struct Flood {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<u64>,
}

impl Flood {
    /// Floods while `on` says so.
    pub(crate) fn start(address: SocketAddr, token: String, on: Arc<AtomicBool>) -> Self {
        let stop = Arc::new(AtomicBool::new(false));
        let thread = std::thread::spawn({
            let stop = Arc::clone(&stop);
            move || flood(address, &token, &stop, &on)
        });
        Self { stop, thread }
    }

    /// How often it was thrown out.
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
