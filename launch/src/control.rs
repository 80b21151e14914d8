//! Between the launcher and the commands that ask it for something: one JSON
//! line there, one back, over a socket in the run directory.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::{UnixListener, UnixStream};
use std::path::Path;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::failure::{Context, Failure};

/// Longest request (bytes).
const MAX_REQUEST: u64 = 4096;
/// A client that says nothing holds the launcher up for this long at most.
const CLIENT_PATIENCE: Duration = Duration::from_millis(20);

/// Something only the launcher can do.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(tag = "ask", rename_all = "snake_case")]
pub(crate) enum Request {
    /// Stop the cell.
    Down,
    /// Start processes anew.
    Restart {
        /// `physics`, `controller`, `task` or `monitor`.
        process: String,
        /// Policy the task goes on with.
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
pub(crate) struct Reply {
    /// Whether it is done or under way.
    pub(crate) ok: bool,
    /// What to tell the person.
    pub(crate) message: String,
}

/// The launcher's end.
#[derive(Debug)]
pub(crate) struct Server {
    listener: UnixListener,
}

impl Server {
    /// Listens at `path`; nothing of that name exists.
    pub(crate) fn open(path: &Path) -> Result<Self, Failure> {
        let what = format!("open the control socket {}", path.display());
        let listener = UnixListener::bind(path).cannot(&what)?;
        listener.set_nonblocking(true).cannot(&what)?;
        Ok(Self { listener })
    }

    /// Answers one waiting client, if there is one.
    pub(crate) fn poll(&self, answer: impl FnOnce(Request) -> Reply) {
        if let Ok((stream, _)) = self.listener.accept() {
            // A client that went away or sends nonsense is its own problem.
            serve(&stream, answer).ok();
        }
    }
}

fn serve(stream: &UnixStream, answer: impl FnOnce(Request) -> Reply) -> io::Result<()> {
    stream.set_nonblocking(false)?;
    stream.set_read_timeout(Some(CLIENT_PATIENCE))?;
    stream.set_write_timeout(Some(CLIENT_PATIENCE))?;
    let mut line = String::new();
    BufReader::new(stream.take(MAX_REQUEST)).read_line(&mut line)?;
    let reply = match serde_json::from_str(&line) {
        Ok(request) => answer(request),
        Err(error) => Reply {
            ok: false,
            message: format!("not a request: {error}"),
        },
    };
    let mut stream = stream;
    writeln!(stream, "{}", serde_json::to_string(&reply)?)
}

/// Asks the launcher whose socket is at `path`.
pub(crate) fn ask(path: &Path, request: &Request) -> Result<Reply, Failure> {
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

    #[test]
    fn a_request_is_answered_and_nonsense_is_refused() {
        let path = std::env::temp_dir().join(format!("robocell-control-{}", std::process::id()));
        let server = Server::open(&path).unwrap();
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
        server.poll(|_| panic!("not a request"));
        let mut line = String::new();
        stream.read_to_string(&mut line).unwrap();
        assert!(line.contains("explode"), "{line}");
        std::fs::remove_file(path).unwrap();
    }
}
