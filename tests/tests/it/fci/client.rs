//! A client of the Franka control interface, as libfranka is one.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream, UdpSocket};
use std::time::Duration;

/// How long a client of libfranka waits for a state or a reply.
const PATIENCE: Duration = Duration::from_secs(1);

/// A state, as far as the tests read it.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub(super) id: u64,
    /// Commanded position and velocity of joint 7.
    pub(super) position: f32,
    pub(super) velocity: f32,
    pub(super) generator_mode: u8,
    pub(super) robot_mode: u8,
}

impl State {
    fn read(bytes: &[u8]) -> Self {
        assert_eq!(bytes.len(), 1377, "a state");
        let number = |at: usize| f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        Self {
            id: u64::from_le_bytes(bytes[..8].try_into().unwrap()),
            position: number(624 + 24),
            velocity: number(652 + 28 + 24),
            generator_mode: bytes[1288],
            robot_mode: bytes[1372],
        }
    }
}

pub(super) struct Client {
    tcp: TcpStream,
    udp: UdpSocket,
    /// Where states come from.
    server: Option<std::net::SocketAddr>,
    requests: u32,
}

/// Why a connection has no robot.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Refused {
    /// By this version.
    Version(u16),
    /// The connection was closed.
    Closed,
}

impl Client {
    /// Connects with this version of the protocol; waits until the interface listens.
    pub(super) fn connect(address: Ipv4Addr, version: u16) -> Result<Self, Refused> {
        let udp = UdpSocket::bind("0.0.0.0:0").unwrap();
        let port = udp.local_addr().unwrap().port();
        udp.set_read_timeout(Some(PATIENCE)).unwrap();
        let tcp = robocell_tests::program::wait_for("the interface listens", || {
            TcpStream::connect((address, 1337)).ok()
        });
        // Longer than libfranka's: a loaded machine is no fault of the interface.
        tcp.set_read_timeout(Some(20 * PATIENCE)).unwrap();
        let mut client = Self {
            tcp,
            udp,
            server: None,
            requests: 0,
        };
        let body = [version.to_le_bytes(), port.to_le_bytes()].concat();
        client.send(0, &body);
        let reply = client.reply().ok_or(Refused::Closed)?;
        assert_eq!(reply[..8], [0; 8], "a reply to the connect");
        if reply[12] != 0 {
            return Err(Refused::Version(u16::from_le_bytes([reply[13], reply[14]])));
        }
        Ok(client)
    }

    fn send(&mut self, command: u32, body: &[u8]) {
        let size = u32::try_from(12 + body.len()).unwrap();
        let mut bytes: Vec<u8> = [command, self.requests, size]
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect();
        bytes.extend(body);
        self.requests += 1;
        self.tcp.write_all(&bytes).unwrap();
    }

    /// The next reply; `None` where the connection is closed.
    fn reply(&mut self) -> Option<Vec<u8>> {
        let mut header = [0; 12];
        self.tcp.read_exact(&mut header).ok()?;
        let size = u32::from_le_bytes(header[8..].try_into().unwrap()) as usize;
        let mut bytes = header.to_vec();
        bytes.resize(size, 0);
        self.tcp.read_exact(&mut bytes[12..]).ok()?;
        Some(bytes)
    }

    /// Status of the next reply.
    pub(super) fn status(&mut self) -> u8 {
        self.reply().expect("a reply")[12]
    }

    /// The newest state that has arrived, or the next one.
    pub(super) fn state(&mut self) -> State {
        let mut bytes = [0; 1500];
        let (size, from) = self.udp.recv_from(&mut bytes).expect("a state within 1 s");
        let mut state = State::read(&bytes[..size]);
        self.udp.set_nonblocking(true).unwrap();
        while let Ok(size) = self.udp.recv(&mut bytes) {
            state = State::read(&bytes[..size]);
        }
        self.udp.set_nonblocking(false).unwrap();
        self.server = Some(from);
        state
    }

    /// Starts a motion of joint velocities; the first state of it.
    pub(super) fn start(&mut self) -> State {
        let mut body = vec![0; 113];
        body[4] = 1;
        self.send(1, &body);
        let status = self.status();
        assert_eq!(
            status, 1,
            "the motion has started: {} requests",
            self.requests
        );
        for _ in 0..20_000 {
            let state = self.state();
            if state.robot_mode == 2 && state.generator_mode == 2 {
                return state;
            }
        }
        panic!("no state shows the motion");
    }

    /// Answers a state with a velocity of joint 7 (rad/s).
    pub(super) fn answer(&self, state: &State, velocity: f64, is_finished: bool) {
        let mut bytes = [0; 371];
        bytes[..8].copy_from_slice(&state.id.to_le_bytes());
        bytes[64 + 48..64 + 56].copy_from_slice(&velocity.to_le_bytes());
        bytes[313] = u8::from(is_finished);
        self.udp.send_to(&bytes, self.server.unwrap()).unwrap();
    }

    /// Turns joint 7 by 0.1 rad in so many cycles of a bell; the status of the motion.
    pub(super) fn turn(&mut self, cycles: u32) -> u8 {
        let mut state = self.start();
        let speed = 0.2e3 / f64::from(cycles);
        for cycle in 0..=cycles {
            let part = f64::from(cycle) / f64::from(cycles);
            let velocity = speed * (std::f64::consts::PI * part).sin().powi(2);
            self.answer(&state, velocity, cycle == cycles);
            state = self.state();
        }
        // Repeated until the robot is idle, as libfranka does.
        while state.robot_mode == 2 {
            self.answer(&state, 0.0, true);
            state = self.state();
        }
        self.status()
    }

    /// Ends a reflex.
    pub(super) fn recover(&mut self) {
        self.send(10, &[]);
        assert_eq!(self.status(), 0, "recovered");
    }

    /// The URDF of the robot.
    pub(super) fn model(&mut self) -> String {
        self.send(11, &[]);
        let reply = self.reply().expect("a model");
        String::from_utf8(reply[13..].to_vec()).expect("text")
    }
}
