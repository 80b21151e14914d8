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
/// A client that has not said what it wants after this is let go.
const CLIENT_PATIENCE: Duration = Duration::from_secs(1);
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

/// The launcher's end. Nothing a client does or leaves undone makes it wait.
#[derive(Debug)]
pub(crate) struct Server {
    listener: UnixListener,
    /// Who has not said all yet, the oldest first.
    clients: VecDeque<Client>,
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
        })
    }

    /// Answers those who have said what they want.
    pub(crate) fn poll(&mut self, mut answer: impl FnMut(Request) -> Reply) {
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
        self.clients.retain_mut(|client| match client.line() {
            Ok(Some(line)) => {
                // One that went away or reads nothing is its own problem.
                client.tell(&reply_to(&line, &mut answer)).ok();
                false
            }
            Ok(None) => client.since.elapsed() < CLIENT_PATIENCE,
            Err(_) => false,
        });
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
            if let Some(end) = end.or((self.said.len() >= MAX_REQUEST).then_some(MAX_REQUEST)) {
                self.said.truncate(end);
                return Ok(Some(String::from_utf8_lossy(&self.said).into_owned()));
            }
        }
    }

    fn tell(&mut self, reply: &Reply) -> io::Result<()> {
        writeln!(self.stream, "{}", serde_json::to_string(reply)?)
    }
}

fn reply_to(line: &str, answer: &mut impl FnMut(Request) -> Reply) -> Reply {
    match serde_json::from_str(line) {
        Ok(request) => answer(request),
        Err(error) => Reply {
            ok: false,
            message: format!("not a request: {error}"),
        },
    }
}

/// Asks the launcher whose socket is at `path`.
pub fn ask(path: &Path, request: &Request) -> Result<Reply, Failure> {
    let talk = || -> io::Result<Reply> {
        let mut stream = UnixStream::connect(path)?;
        stream.set_read_timeout(Some(Duration::from_secs(5)))?;
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
                Reply {
                    ok: true,
                    message: "fine".to_owned(),
                }
            });
        }
        assert_eq!(seen, Some(request));
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
