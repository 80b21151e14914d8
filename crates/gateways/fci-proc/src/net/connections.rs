//! The TCP connections of clients.

use std::collections::BTreeMap;
use std::io::{self, Read, Write};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::Builder;
use std::time::Duration;

use fci::{
    Framed, GRIPPER_REQUEST_BYTES, GRIPPER_VERSION, GripperFramed, GripperReply, GripperRequest,
    REQUEST_BYTES, Reply, Request, VERSION, decode, decode_gripper,
};

use super::{Event, Received};

/// Connections at a time, also those without a client yet; with one more the oldest of those
/// is closed.
const MOST_CONNECTIONS: usize = 32;
/// How long a reply may wait for a client that does not read.
const WRITE_TIMEOUT: Duration = Duration::from_secs(1);

/// How often, and at which interval, a client asks whether the last one has ended.
// Half a second in all: libfranka waits one second for a reply.
const CLAIMS: u32 = 25;
const CLAIM_PAUSE: Duration = Duration::from_millis(20);

/// Replies of a connection are not written: the version differs.
const OTHER_VERSION: u8 = 1;

/// The connections of both ports.
pub(super) struct Connections {
    events: SyncSender<Event>,
    urdf: String,
    open: Mutex<BTreeMap<u64, Arc<TcpStream>>>,
    next: AtomicU64,
    /// The connection whose client has the arm; 0 for none.
    client: AtomicU64,
    hand_client: AtomicU64,
}

/// Accepts connections of the arm, or of the hand, on a thread of its own.
pub(super) fn accept(
    connections: Arc<Connections>,
    listener: TcpListener,
    is_hand: bool,
) -> io::Result<()> {
    let name = if is_hand { "hand" } else { "arm" };
    let work = move || {
        for stream in listener.incoming() {
            match stream {
                Ok(stream) => connections.open(stream, is_hand),
                // Without free descriptors the next attempt fails at once, too.
                Err(_) => std::thread::sleep(Duration::from_millis(10)),
            }
        }
    };
    Builder::new().name(name.to_owned()).spawn(work).map(|_| ())
}

impl Connections {
    pub(super) fn new(events: SyncSender<Event>, urdf: String) -> Self {
        Self {
            events,
            urdf,
            open: Mutex::new(BTreeMap::new()),
            next: AtomicU64::new(1),
            client: AtomicU64::new(0),
            hand_client: AtomicU64::new(0),
        }
    }

    fn open(self: &Arc<Self>, stream: TcpStream, is_hand: bool) {
        let connection = self.next.fetch_add(1, Ordering::Relaxed);
        let stream = Arc::new(stream);
        // Replies are small and must not wait for the next one.
        let _set = stream.set_nodelay(true).is_ok();
        let _set = stream.set_write_timeout(Some(WRITE_TIMEOUT)).is_ok();
        self.make_room();
        self.lock().insert(connection, Arc::clone(&stream));
        let all = Arc::clone(self);
        let name = if is_hand { "hand-client" } else { "arm-client" };
        let serve = move || {
            if is_hand {
                all.serve_hand(connection, &stream);
            } else {
                all.serve_arm(connection, &stream);
            }
            all.end(connection, is_hand);
        };
        if Builder::new().name(name.to_owned()).spawn(serve).is_err() {
            self.close(connection);
            self.lock().remove(&connection);
        }
    }

    /// Closes the oldest connection without a client where there are too many.
    fn make_room(&self) {
        let served = [&self.client, &self.hand_client].map(|served| served.load(Ordering::Acquire));
        let open = self.lock();
        if open.len() < MOST_CONNECTIONS {
            return;
        }
        let idle = open.iter().find(|(number, _)| !served.contains(number));
        if let Some((_, stream)) = idle {
            cell_worker::warn(format_args!(
                "more than {MOST_CONNECTIONS} connections: the oldest without a client is closed"
            ));
            let _closed = stream.shutdown(Shutdown::Both).is_ok();
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<u64, Arc<TcpStream>>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn write(&self, connection: u64, bytes: &[u8]) {
        let stream = self.lock().get(&connection).cloned();
        if let Some(stream) = stream
            && (&*stream).write_all(bytes).is_err()
        {
            self.close(connection);
        }
    }

    pub(super) fn close(&self, connection: u64) {
        if let Some(stream) = self.lock().get(&connection) {
            let _closed = stream.shutdown(Shutdown::Both).is_ok();
        }
    }

    fn end(&self, connection: u64, is_hand: bool) {
        self.lock().remove(&connection);
        let (served, event) = if is_hand {
            (&self.hand_client, Event::HandClosed(connection))
        } else {
            (&self.client, Event::Closed(connection))
        };
        let ordering = Ordering::AcqRel;
        // Refused connections end here, too: they must not free the arm of the client that has it.
        let was_served = served.compare_exchange(connection, 0, ordering, Ordering::Acquire);
        if was_served.is_ok() {
            self.tell(&event);
        }
    }

    fn tell(&self, event: &Event) {
        // The control loop takes events in every cycle; it has ended where this fails.
        let _told = self.events.send(*event).is_ok();
    }

    /// Reads the requests of a client of the arm until it goes, or sends none.
    fn serve_arm(&self, connection: u64, stream: &TcpStream) {
        let Ok(peer) = stream.peer_addr() else {
            return;
        };
        let mut input = Input::<REQUEST_BYTES>::new();
        while input.read(stream) {
            loop {
                let framed = match decode(input.bytes()) {
                    Ok(Some(framed)) => framed,
                    Ok(None) => break,
                    Err(malformed) => {
                        cell_worker::warn(format_args!("FCI client {peer}: {malformed}"));
                        return;
                    }
                };
                let received = input.take(framed.size);
                if !self.serve(connection, peer, (&framed, received)) {
                    return;
                }
            }
        }
    }

    /// Executes or hands over a request; `false` ends the connection.
    fn serve(
        &self,
        connection: u64,
        peer: SocketAddr,
        (framed, received): (&Framed, Received),
    ) -> bool {
        let reply = |status| Reply {
            command: framed.command,
            id: framed.id,
            status,
        };
        match framed.request {
            Request::Connect { version, .. } if version != VERSION => {
                cell_worker::warn(format_args!(
                    "FCI client {peer} speaks version {version} of the arm's protocol; \
                     {VERSION} is served (libfranka 0.18 and later)"
                ));
                let refusal = reply(OTHER_VERSION).encode(&VERSION.to_le_bytes());
                self.write(connection, &refusal);
                false
            }
            Request::Connect { udp_port, .. } => {
                if !claim(&self.client, connection, peer) {
                    return false;
                }
                self.write(connection, &reply(0).encode(&VERSION.to_le_bytes()));
                let states = SocketAddr::new(peer.ip(), udp_port);
                self.tell(&Event::Connected(connection, states));
                true
            }
            // The first request must be a connect.
            _ if self.client.load(Ordering::Acquire) != connection => false,
            Request::GetRobotModel => {
                self.write(connection, &reply(0).encode(self.urdf.as_bytes()));
                true
            }
            _ => {
                self.tell(&Event::Request(connection, received));
                true
            }
        }
    }

    /// As [`Connections::serve_arm`], for the hand.
    fn serve_hand(&self, connection: u64, stream: &TcpStream) {
        let Ok(peer) = stream.peer_addr() else {
            return;
        };
        let mut input = Input::<GRIPPER_REQUEST_BYTES>::new();
        while input.read(stream) {
            loop {
                let framed = match decode_gripper(input.bytes()) {
                    Ok(Some(framed)) => framed,
                    Ok(None) => break,
                    Err((command, size)) => {
                        cell_worker::warn(format_args!(
                            "gripper client {peer}: command {command} of {size} bytes; \
                             commands 0 to 4 are known"
                        ));
                        return;
                    }
                };
                let received = input.take(framed.size);
                if !self.serve_gripper(connection, peer, (&framed, received)) {
                    return;
                }
            }
        }
    }

    fn serve_gripper(
        &self,
        connection: u64,
        peer: SocketAddr,
        (framed, received): (&GripperFramed, Received),
    ) -> bool {
        let GripperRequest::Connect { version, udp_port } = framed.request else {
            if self.hand_client.load(Ordering::Acquire) != connection {
                return false;
            }
            self.tell(&Event::HandRequest(connection, received));
            return true;
        };
        let is_known = version == GRIPPER_VERSION;
        if !is_known {
            cell_worker::warn(format_args!(
                "gripper client {peer} speaks version {version}; {GRIPPER_VERSION} is served"
            ));
        }
        if is_known && !claim(&self.hand_client, connection, peer) {
            return false;
        }
        let reply = GripperReply {
            command: framed.command,
            id: framed.id,
            status: u16::from(!is_known),
        };
        self.write(connection, &reply.encode(&GRIPPER_VERSION.to_le_bytes()));
        if is_known {
            let states = SocketAddr::new(peer.ip(), udp_port);
            self.tell(&Event::HandConnected(connection, states));
        }
        is_known
    }
}

/// Makes the connection the one that has the arm, or the hand; `false` where another has.
fn claim(served: &AtomicU64, connection: u64, peer: SocketAddr) -> bool {
    let free = || {
        let ordering = Ordering::AcqRel;
        let claimed = served.compare_exchange(0, connection, ordering, Ordering::Acquire);
        claimed.is_ok() || claimed == Err(connection)
    };
    // A program that was started again connects while the end of the last one is on its way.
    for _ in 0..CLAIMS {
        if free() {
            return true;
        }
        std::thread::sleep(CLAIM_PAUSE);
    }
    cell_worker::warn(format_args!(
        "FCI client {peer} is refused: another client is connected"
    ));
    false
}

/// Bytes of a connection before its next request is complete.
struct Input<const N: usize> {
    bytes: [u8; N],
    used: usize,
}

impl<const N: usize> Input<N> {
    fn new() -> Self {
        Self {
            bytes: [0; N],
            used: 0,
        }
    }

    /// Waits for more bytes; `false` at the end of the connection.
    fn read(&mut self, mut stream: &TcpStream) -> bool {
        let Some(room) = self.bytes.get_mut(self.used..) else {
            return false;
        };
        match stream.read(room) {
            Ok(0) | Err(_) => false,
            Ok(count) => {
                self.used += count;
                true
            }
        }
    }

    fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.used).unwrap_or_default()
    }

    /// Removes the first `count` bytes, and returns them.
    fn take(&mut self, count: usize) -> Received {
        let received = Received::of(self.bytes().get(..count).unwrap_or_default());
        self.bytes.copy_within(count.min(self.used)..self.used, 0);
        self.used = self.used.saturating_sub(count);
        received
    }
}
