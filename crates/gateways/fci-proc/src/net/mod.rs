//! The sockets of the interface.
//!
//! A thread accepts connections, and a thread for each reads its requests; another writes the
//! replies. The control loop exchanges plain values with them by channels that it only tries,
//! and sends and receives datagrams itself, without waiting.

mod connections;

use std::io::{self, ErrorKind};
use std::net::{IpAddr, SocketAddr, TcpListener, UdpSocket};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::Builder;

use fci::{COMMAND_BYTES, GRIPPER_STATE_BYTES, GripperReply, REQUEST_BYTES, Reply, STATE_BYTES};

use connections::Connections;

/// TCP port of the arm.
const ARM_PORT: u16 = 1337;
/// TCP port of the hand.
const HAND_PORT: u16 = 1338;
/// Requests and replies that can wait for their thread.
// A client sends a request when it has the reply to the last one; a few are in flight at the
// change of clients.
const IN_FLIGHT: usize = 64;

/// A complete request, as received.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Received {
    bytes: [u8; REQUEST_BYTES],
    len: usize,
}

impl Received {
    /// Bytes beyond the longest request are left out.
    fn of(request: &[u8]) -> Self {
        let len = request.len().min(REQUEST_BYTES);
        let mut bytes = [0; REQUEST_BYTES];
        for (to, from) in bytes.iter_mut().zip(request) {
            *to = *from;
        }
        Self { bytes, len }
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or_default()
    }
}

/// What a connection has for the control loop.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Event {
    /// A client of the arm: its connection, and where it wants states.
    Connected(u64, SocketAddr),
    /// Its request.
    Request(u64, Received),
    /// Its connection has ended.
    Closed(u64),
    /// A client of the hand.
    HandConnected(u64, SocketAddr),
    /// Its request.
    HandRequest(u64, Received),
    /// Its connection has ended.
    HandClosed(u64),
}

/// What the control loop has for a connection.
#[derive(Clone, Copy, Debug)]
enum Outgoing {
    Reply(u64, Reply),
    HandReply(u64, GripperReply),
    Close(u64),
}

/// The sockets, as the control loop sees them.
pub(crate) struct Net {
    events: Receiver<Event>,
    outgoing: SyncSender<Outgoing>,
    arm: UdpSocket,
    hand: UdpSocket,
    /// Connection and address for states.
    client: Option<(u64, SocketAddr)>,
    hand_client: Option<(u64, SocketAddr)>,
}

impl Net {
    /// Listens at `address`; `urdf` is the model that clients ask for.
    pub(crate) fn listen(address: IpAddr, urdf: String, has_hand: bool) -> io::Result<Self> {
        let (to_loop, events) = sync_channel(IN_FLIGHT);
        let (outgoing, to_write) = sync_channel(IN_FLIGHT);
        let connections = Arc::new(Connections::new(to_loop, urdf));
        let listener = listener(address, ARM_PORT)?;
        connections::accept(Arc::clone(&connections), listener, false)?;
        if has_hand {
            let listener = self::listener(address, HAND_PORT)?;
            connections::accept(Arc::clone(&connections), listener, true)?;
        }
        Builder::new()
            .name("replies".to_owned())
            .spawn(move || write(&to_write, &connections))?;
        let udp = || {
            let socket = UdpSocket::bind((address, 0))?;
            socket.set_nonblocking(true)?;
            Ok::<UdpSocket, io::Error>(socket)
        };
        Ok(Self {
            events,
            outgoing,
            arm: udp()?,
            hand: udp()?,
            client: None,
            hand_client: None,
        })
    }

    /// The next event. Events of a former client are left out.
    pub(crate) fn event(&mut self) -> Option<Event> {
        loop {
            let event = self.events.try_recv().ok()?;
            let is_of = |client: Option<(u64, SocketAddr)>, connection: u64| {
                client.is_some_and(|(served, _)| served == connection)
            };
            match event {
                Event::Connected(connection, at) => self.client = Some((connection, at)),
                Event::HandConnected(connection, at) => self.hand_client = Some((connection, at)),
                Event::Request(connection, _) if !is_of(self.client, connection) => continue,
                Event::Closed(connection) if !is_of(self.client, connection) => continue,
                Event::Closed(_) => self.client = None,
                Event::HandRequest(connection, _) if !is_of(self.hand_client, connection) => {
                    continue;
                }
                Event::HandClosed(connection) if !is_of(self.hand_client, connection) => continue,
                Event::HandClosed(_) => self.hand_client = None,
                Event::Request(..) | Event::HandRequest(..) => {}
            }
            return Some(event);
        }
    }

    /// The next command of the client, as received.
    pub(crate) fn command(&self) -> Option<[u8; COMMAND_BYTES]> {
        // One byte more, to refuse a longer datagram.
        let mut bytes = [0; COMMAND_BYTES + 1];
        loop {
            let (size, from) = match self.arm.recv_from(&mut bytes) {
                Ok(received) => received,
                // A client that has ended: the kernel reports it at the next call.
                Err(error) if error.kind() == ErrorKind::ConnectionRefused => continue,
                Err(_) => return None,
            };
            let is_of_client = self.client.is_some_and(|(_, client)| client == from);
            let command = bytes.get(..size).and_then(|bytes| bytes.try_into().ok());
            if let Some(command) = command.filter(|_| is_of_client) {
                return Some(command);
            }
        }
    }

    /// Sends a state; one that cannot be sent is lost, as on a network.
    pub(crate) fn send(&self, state: &[u8; STATE_BYTES]) {
        if let Some((_, to)) = self.client {
            let _sent = self.arm.send_to(state, to).is_ok();
        }
    }

    /// Sends a state of the hand.
    pub(crate) fn send_hand(&self, state: &[u8; GRIPPER_STATE_BYTES]) {
        if let Some((_, to)) = self.hand_client {
            let _sent = self.hand.send_to(state, to).is_ok();
        }
    }

    /// Replies to the client.
    pub(crate) fn reply(&self, reply: Reply) {
        if let Some((connection, _)) = self.client {
            self.put(Outgoing::Reply(connection, reply));
        }
    }

    /// Replies to the client of the hand.
    pub(crate) fn reply_hand(&self, reply: GripperReply) {
        if let Some((connection, _)) = self.hand_client {
            self.put(Outgoing::HandReply(connection, reply));
        }
    }

    /// Ends the connection of a client that does not answer.
    pub(crate) fn drop_client(&mut self) {
        if let Some((connection, _)) = self.client.take() {
            self.put(Outgoing::Close(connection));
        }
    }

    fn put(&self, outgoing: Outgoing) {
        // A full channel means that the writer waits for a client that does not read: such a
        // client waits for its reply in vain.
        let _sent = self.outgoing.try_send(outgoing).is_ok();
    }
}

fn listener(address: IpAddr, port: u16) -> io::Result<TcpListener> {
    TcpListener::bind((address, port))
        .map_err(|error| io::Error::new(error.kind(), format!("{address}:{port}: {error}")))
}

/// Writes replies until the control loop has ended.
fn write(outgoing: &Receiver<Outgoing>, connections: &Connections) {
    for message in outgoing {
        match message {
            Outgoing::Reply(connection, reply) => connections.write(connection, &reply.encode(&[])),
            Outgoing::HandReply(connection, reply) => {
                connections.write(connection, &reply.encode(&[]));
            }
            Outgoing::Close(connection) => connections.close(connection),
        }
    }
}
