//! The connection to a policy server, on a thread of its own: a decision waits for it in
//! simulated time, and does not in real time.

mod timed;

use std::collections::BTreeMap;
use std::io::{self, ErrorKind};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, TryRecvError, channel};
use std::time::{Duration, Instant};

use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

use crate::codec::{self, AnswerError, Convention, Observations, Rows};
use crate::failure::{Failure, reason};
use crate::kept::Seen;
use timed::{Extension, Timed, is_late};

/// Longest wait for a server that is not known yet, from the connection to the end of its
/// greeting.
const GREETING_LIMIT: Duration = Duration::from_secs(10);
/// Longest wait for the first message of a server that speaks first; part of the greeting.
const HELLO_LIMIT: Duration = Duration::from_secs(3);
/// Longest wait for an answer: a model may be compiled for its first one.
const ANSWER_LIMIT: Duration = Duration::from_secs(120);
/// Time without an observation after which pings are answered.
const IDLE: Duration = Duration::from_secs(5);
/// Largest message of a server (bytes).
pub const MAX_MESSAGE_BYTES: usize = 16 * 1024 * 1024;

/// A connection of one episode.
#[derive(Debug)]
pub(crate) struct Link {
    requests: Sender<Observations>,
    answers: Receiver<Result<Rows, Failure>>,
}

impl Link {
    /// Begins to connect to `address`, as `ws://127.0.0.1:8765`. Observations are sent under the
    /// keys of `names`; without any, under those of the server's convention.
    pub(crate) fn open(address: &str, names: &BTreeMap<String, String>, seen: &Arc<Seen>) -> Self {
        let (requests, observations) = channel();
        let (results, answers) = channel();
        let (address, names, seen) = (address.to_owned(), names.clone(), seen.clone());
        let serve = move || {
            let ended = Connection::open(&address, names, &seen, GREETING_LIMIT)
                .and_then(|connection| connection.serve(&observations, &results));
            if let Err(failure) = ended {
                results.send(Err(failure)).ok();
            }
        };
        // Without a thread the answers end at once, which is reported as a lost connection.
        std::thread::Builder::new()
            .name("policy".to_owned())
            .spawn(serve)
            .ok();
        Self { requests, answers }
    }

    /// Sends observations.
    pub(crate) fn ask(&self, observations: Observations) {
        // A connection that has ended has left its failure behind.
        self.requests.send(observations).ok();
    }

    /// The answer; `None` if there is none yet and `wait` is not set.
    pub(crate) fn answer(&self, wait: bool) -> Option<Result<Rows, Failure>> {
        let lost = || {
            Failure::new(
                reason::LOST,
                "the connection to the policy server has ended",
            )
        };
        if !wait {
            return match self.answers.try_recv() {
                Ok(answer) => Some(answer),
                Err(TryRecvError::Empty) => None,
                Err(TryRecvError::Disconnected) => Some(Err(lost())),
            };
        }
        // The thread has limits of its own; this one holds if it is stuck in a name server.
        let limit = 2 * (GREETING_LIMIT + HELLO_LIMIT + ANSWER_LIMIT);
        Some(match self.answers.recv_timeout(limit) {
            Ok(answer) => answer,
            Err(RecvTimeoutError::Timeout) => Err(late()),
            Err(RecvTimeoutError::Disconnected) => Err(lost()),
        })
    }
}

fn late() -> Failure {
    let limit_s = ANSWER_LIMIT.as_secs();
    Failure::new(
        reason::LATE,
        format!("the policy server did not answer within {limit_s} s"),
    )
}

struct Connection {
    socket: WebSocket<Timed>,
    convention: Convention,
    names: BTreeMap<String, String>,
    /// Messages sent.
    number: u64,
}

impl Connection {
    /// Connects and greets within `limit`. A server of this address that computes for another
    /// connection, which knows it, may take as long as for an answer.
    fn open(
        address: &str,
        names: BTreeMap<String, String>,
        seen: &Arc<Seen>,
        limit: Duration,
    ) -> Result<Self, Failure> {
        let refused = |why: String| {
            Failure::new(
                reason::UNREACHABLE,
                format!("{address}: {why}; start the policy server, or correct --policy"),
            )
        };
        let start = Instant::now();
        let until = start + limit;
        let mute = || {
            let limit_s = limit.as_secs_f64();
            refused(format!(
                "the connection was accepted, but no policy server greeted within {limit_s} s"
            ))
        };
        let stream = connect(address, until).map_err(|error| refused(error.to_string()))?;
        stream.set_nodelay(true).ok();
        let config = WebSocketConfig::default()
            .max_message_size(Some(MAX_MESSAGE_BYTES))
            .max_frame_size(Some(MAX_MESSAGE_BYTES));
        let stream = Timed {
            stream,
            until,
            extension: Some(Extension {
                until: start + ANSWER_LIMIT,
                address: address.to_owned(),
                seen: seen.clone(),
            }),
        };
        let (socket, _) = tungstenite::client::client_with_config(address, stream, Some(config))
            .map_err(|error| match error {
                HandshakeError::Failure(Error::Io(error)) if is_late(&error) => mute(),
                error => refused(error.to_string()),
            })?;
        let mut connection = Self {
            socket,
            convention: Convention::OpenPi,
            names,
            number: 0,
        };
        connection.socket.get_mut().extension = None;
        let known = || seen.convention(address);
        let greeted = connection.greet(known, until, start + ANSWER_LIMIT);
        greeted.map_err(|failure| {
            if failure.reason == reason::LATE {
                mute()
            } else {
                failure
            }
        })?;
        seen.found(address, connection.convention);
        Ok(connection)
    }

    /// Finds the convention by `until`: a server of openpi sends the first message, one of vla-eval
    /// waits for a hello. One whose convention is `known` has until `late`.
    fn greet(
        &mut self,
        known: impl Fn() -> Option<Convention>,
        until: Instant,
        late: Instant,
    ) -> Result<(), Failure> {
        let mut convention = known();
        let mut first = None;
        if convention.is_none() {
            first = match self.receive(until.min(Instant::now() + HELLO_LIMIT)) {
                Err(failure) if failure.reason == reason::LATE => None,
                first => Some(first?),
            };
            // Another connection may have found it in this time, and keeps the server busy.
            convention = known();
        }
        if first.is_none() && convention == Some(Convention::OpenPi) {
            first = Some(self.receive(late)?);
        }
        match first {
            Some(first) if !codec::is_hello(&first) => Ok(()),
            first => {
                self.convention = Convention::VlaEval;
                let until = convention.map_or(until, |_| late);
                self.introduce(first.is_none(), until)
            }
        }
    }

    /// Starts an episode in the convention of vla-eval, with a hello if the server sent none.
    fn introduce(&mut self, with_hello: bool, until: Instant) -> Result<(), Failure> {
        if with_hello {
            let version = env!("CARGO_PKG_VERSION");
            self.send_note("hello", &[("harness", "robocell"), ("version", version)])?;
            let reply = self.receive(until)?;
            if !codec::is_hello(&reply) {
                let why = "the policy server uses neither the convention of openpi nor that of \
                           vla-eval: it sent no first message, and did not return a hello";
                return Err(Failure::new(reason::UNREACHABLE, why));
            }
        }
        self.send_note("episode_start", &[])
    }

    /// Answers observations until the policy is dropped.
    fn serve(
        mut self,
        observations: &Receiver<Observations>,
        results: &Sender<Result<Rows, Failure>>,
    ) -> Result<(), Failure> {
        loop {
            let observations = match observations.recv_timeout(IDLE) {
                Ok(observations) => self.named(observations),
                Err(RecvTimeoutError::Disconnected) => break,
                Err(RecvTimeoutError::Timeout) => {
                    self.answer_pings()?;
                    continue;
                }
            };
            let request = codec::request(self.convention, self.number, &observations);
            self.send(request)?;
            let answer = self.receive(Instant::now() + ANSWER_LIMIT)?;
            let rows = codec::actions(self.convention, &answer).map_err(|error| {
                let reason = match error {
                    AnswerError::Reported(_) => reason::ERROR,
                    AnswerError::Invalid(_) => reason::INVALID,
                };
                Failure::new(reason, format!("the answer of the policy server: {error}"))
            })?;
            if results.send(Ok(rows)).is_err() {
                break;
            }
        }
        if self.convention == Convention::VlaEval {
            self.send_note("episode_end", &[])?;
        }
        self.socket.get_mut().until = Instant::now() + HELLO_LIMIT;
        self.socket.close(None).ok();
        Ok(())
    }

    /// Reads while no observation is sent: servers close a connection that answers no ping.
    fn answer_pings(&mut self) -> Result<(), Failure> {
        self.socket.get_mut().until = Instant::now() + Duration::from_millis(10);
        match self.socket.read().map_err(failure_of) {
            Err(failure) if failure.reason != reason::LATE => Err(failure),
            _ => Ok(()),
        }
    }

    fn named(&self, observations: Observations) -> Observations {
        let key = |key: String| match self.names.get(&key) {
            Some(name) => name.clone(),
            None if self.names.is_empty() && self.convention == Convention::VlaEval => {
                by_vla_eval(&key)
            }
            None => key,
        };
        observations
            .into_iter()
            .map(|(name, content)| (key(name), content))
            .collect()
    }

    fn send_note(&mut self, kind: &str, entries: &[(&str, &str)]) -> Result<(), Failure> {
        let note = codec::note(kind, self.number, entries);
        self.send(note)
    }

    fn send(&mut self, bytes: Vec<u8>) -> Result<(), Failure> {
        self.number += 1;
        self.socket.get_mut().until = Instant::now() + ANSWER_LIMIT;
        self.socket.send(Message::binary(bytes)).map_err(failure_of)
    }

    fn receive(&mut self, until: Instant) -> Result<Vec<u8>, Failure> {
        self.socket.get_mut().until = until;
        loop {
            match self.socket.read().map_err(failure_of)? {
                Message::Binary(bytes) => return Ok(bytes.into()),
                // A server of openpi sends its stack trace as text.
                Message::Text(text) => {
                    let said = codec::quoted(text.as_str());
                    return Err(Failure::new(
                        reason::ERROR,
                        format!("the policy server sent text: {said}"),
                    ));
                }
                Message::Close(_) => return Err(failure_of(Error::ConnectionClosed)),
                Message::Ping(_) | Message::Pong(_) | Message::Frame(_) => {}
            }
        }
    }
}

/// Keys by the convention of vla-eval.
fn by_vla_eval(key: &str) -> String {
    match key {
        "agent_pos" => "states".to_owned(),
        "prompt" => "task_description".to_owned(),
        key => key.replacen("pixels/", "images/", 1),
    }
}

fn connect(address: &str, until: Instant) -> io::Result<TcpStream> {
    let place = address.strip_prefix("ws://").unwrap_or(address);
    let place = place.split('/').next().unwrap_or_default();
    let mut last = io::Error::from(ErrorKind::AddrNotAvailable);
    for address in place.to_socket_addrs()? {
        let left = until.saturating_duration_since(Instant::now());
        // A limit of zero is refused by the system.
        match TcpStream::connect_timeout(&address, left.max(Duration::from_millis(1))) {
            Ok(stream) => return Ok(stream),
            Err(error) => last = error,
        }
    }
    Err(last)
}

fn failure_of(error: Error) -> Failure {
    match error {
        Error::Io(error) if is_late(&error) => late(),
        Error::Capacity(error) => Failure::new(
            reason::INVALID,
            format!(
                "the message of the policy server is too large: {error}; at most {MAX_MESSAGE_BYTES} bytes are read"
            ),
        ),
        error => Failure::new(
            reason::LOST,
            format!("the connection to the policy server has ended: {error}"),
        ),
    }
}

#[cfg(test)]
mod tests;
