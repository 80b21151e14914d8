//! Between the launcher and the commands that ask it for something: one JSON
//! line there, one back, over a socket in the run directory.

use std::collections::VecDeque;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::failure::{Context, Failure};

/// Longest request (bytes).
const MAX_REQUEST: usize = 4096;
/// A client that has not sent its request after this is disconnected.
const CLIENT_PATIENCE: Duration = Duration::from_secs(1);
/// A launcher answers at once; one that is stopped must not stop its clients.
const PATIENCE: Duration = Duration::from_secs(5);
/// Another scene may need two builds of 30 minutes, of its task program and of the page.
const LOAD_PATIENCE: Duration = Duration::from_secs(3600);
/// Clients that are listened to at a time; the oldest gives way to the next.
const MAX_CLIENTS: usize = 64;

/// Something only the launcher can do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub enum Request {
    /// Stop the cell.
    Down,
    /// Restart processes.
    Restart {
        /// `physics`, `controller`, `task` or `monitor`.
        process: String,
        /// Policy the task continues with.
        policy: Option<String>,
    },
    /// Take the cell down and set up another scene in its place, which waits
    /// for resume.
    Load {
        /// Name of the demo.
        demo: String,
        /// Its default where missing.
        policy: Option<String>,
        /// Seed of the scene.
        seed: u64,
        /// As on the command line.
        speed: String,
    },
}

/// The launcher's answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reply {
    /// Whether it is done or under way.
    pub ok: bool,
    /// What to tell the person.
    pub message: String,
}

impl Reply {
    /// It is not done.
    pub(crate) fn refused(message: impl std::fmt::Display) -> Self {
        Self {
            ok: false,
            message: message.to_string(),
        }
    }

    /// It is done or under way.
    pub(crate) fn accepted(message: String) -> Self {
        Self { ok: true, message }
    }
}

/// The launcher's end. Nothing a client does or leaves undone makes it wait.
#[derive(Debug)]
pub(crate) struct Server {
    listener: UnixListener,
    /// Clients whose request is not complete, the oldest first.
    clients: VecDeque<Client>,
    /// A client whose answer takes longer.
    waiting: Option<Client>,
}

#[derive(Debug)]
struct Client {
    stream: UnixStream,
    said: Vec<u8>,
    since: Instant,
}

impl Server {
    /// Listens at `path`; nothing of that name exists.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let what = format!("open the control socket {}", path.display());
        let listener = UnixListener::bind(path).cannot(&what)?;
        listener.set_nonblocking(true).cannot(&what)?;
        Ok(Self {
            listener,
            clients: VecDeque::new(),
            waiting: None,
        })
    }

    /// Answers the clients whose request is complete. If an answer takes longer, the client
    /// waits for [`Server::answer`].
    pub(crate) fn poll(&mut self, mut answer: impl FnMut(Request) -> Option<Reply>) {
        // A limit, as a flood of connections must not hold up the loop of supervision.
        for _ in 0..MAX_CLIENTS {
            let Ok((stream, _)) = self.listener.accept() else {
                break;
            };
            if self.clients.len() >= MAX_CLIENTS {
                self.clients.pop_front();
            }
            // One that cannot be served without waiting is not served.
            if stream.set_nonblocking(true).is_ok() {
                self.clients.push_back(Client {
                    stream,
                    said: Vec::new(),
                    since: Instant::now(),
                });
            }
        }
        for mut client in std::mem::take(&mut self.clients) {
            match client.line() {
                Ok(Some(line)) => match reply_to(&line, &mut answer) {
                    Some(reply) => client.tell(&reply),
                    // No other client waits: a second `load` is refused while a scene is planned.
                    None => self.waiting = Some(client),
                },
                Ok(None) if client.since.elapsed() < CLIENT_PATIENCE => {
                    self.clients.push_back(client);
                }
                Ok(None) | Err(_) => {}
            }
        }
    }

    /// Answers the client that waits, if one does.
    pub(crate) fn answer(&mut self, reply: &Reply) {
        if let Some(mut client) = self.waiting.take() {
            client.tell(reply);
        }
    }
}

impl Client {
    /// The line it has sent, when it has sent all of it.
    fn line(&mut self) -> io::Result<Option<String>> {
        let mut bytes = [0; MAX_REQUEST];
        loop {
            match self.stream.read(&mut bytes) {
                Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.said.extend(bytes.iter().take(count)),
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => return Ok(None),
                Err(error) => return Err(error),
            }
            let end = self.said.iter().position(|byte| *byte == b'\n');
            // A longer request is cut and then refused: a client must not fill our memory.
            if let Some(end) = end.or((self.said.len() >= MAX_REQUEST).then_some(MAX_REQUEST)) {
                self.said.truncate(end);
                return Ok(Some(String::from_utf8_lossy(&self.said).into_owned()));
            }
        }
    }

    fn tell(&mut self, reply: &Reply) {
        if let Ok(line) = serde_json::to_string(reply) {
            // One that went away or reads nothing is its own problem.
            writeln!(self.stream, "{line}").ok();
        }
    }
}

fn reply_to(line: &str, answer: &mut impl FnMut(Request) -> Option<Reply>) -> Option<Reply> {
    match serde_json::from_str(line) {
        Ok(request) => answer(request),
        Err(error) => Some(Reply::refused(format_args!("not a request: {error}"))),
    }
}

/// Asks the launcher whose socket is at `path`.
pub fn ask(path: &Path, request: &Request) -> Result<Reply, Failure> {
    let talk = || -> io::Result<Reply> {
        let mut stream = UnixStream::connect(path)?;
        let patience = match request {
            Request::Load { .. } => LOAD_PATIENCE,
            Request::Down | Request::Restart { .. } => PATIENCE,
        };
        stream.set_read_timeout(Some(patience))?;
        writeln!(stream, "{}", serde_json::to_string(request)?)?;
        let mut line = String::new();
        BufReader::new(stream.take(1 << 16)).read_line(&mut line)?;
        Ok(serde_json::from_str(&line)?)
    };
    talk().cannot(format!("talk to the launcher at {}", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn connect(path: &Path) -> Option<UnixStream> {
        UnixStream::connect(path).ok()
    }

    #[test]
    fn a_request_is_answered_and_nonsense_is_refused() {
        let path = std::env::temp_dir().join(format!("robocell-control-{}", std::process::id()));
        let mut server = Server::open(&path).unwrap();
        let request = Request::Restart {
            process: "task".to_owned(),
            policy: None,
        };
        let client = std::thread::spawn({
            let (path, request) = (path.clone(), request.clone());
            move || ask(&path, &request).unwrap()
        });
        let mut seen = None;
        while seen.is_none() {
            server.poll(|request| {
                seen = Some(request);
                None
            });
        }
        assert_eq!(seen, Some(request));
        server.answer(&Reply::accepted("fine".to_owned()));
        assert_eq!(client.join().unwrap().message, "fine");
        let mut stream = UnixStream::connect(&path).unwrap();
        stream.write_all(b"{\"ask\": \"explode\"}\n").unwrap();
        let mut silent: Vec<_> = (0..100).map_while(|_| connect(&path)).collect();
        stream.set_nonblocking(true).unwrap();
        let mut line = String::new();
        while stream.read_to_string(&mut line).is_err() {
            server.poll(|_| panic!("not a request"));
            silent.extend(connect(&path));
        }
        assert!(line.contains("explode"), "{line}");
        std::fs::remove_file(path).unwrap();
    }
}
