//! A server with a broadcast only the test sends to, and blunt clients.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    dead_code,
    unreachable_pub,
    reason = "a test fails by panicking; not every test uses every part"
)]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use cell_run::incident::Incidents;
use cell_run::spec::PageSecrets;
use monitor_proc::feed::broadcast::Broadcast;
use monitor_proc::feed::hello::{Hello, RunInfo};
use monitor_proc::page::command::{Names, Order};
use monitor_proc::page::queue::{Answer, CommandQueue, Reply, send};
use monitor_proc::timeline::scrub::{OpenPast, PastReader, PastSpan, SeekTarget};
use monitor_proc::web::access::AccessControl;
use monitor_proc::web::files::Files;
use monitor_proc::web::{KeptIncidents, Search, SearchOf, Services, bind};
use serde_json::{Value, json};
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

pub const OPERATOR: &str = "0123456789abcdef0123456789abcdef";
pub const VIEWER: &str = "fedcba9876543210fedcba9876543210";
/// A hung server fails a test; it does not hang it.
const PATIENCE: Duration = Duration::from_secs(20);

pub type Socket = WebSocket<TcpStream>;

/// Remembers its requests, and accepts them.
#[derive(Default)]
pub struct FakeQueue(pub Mutex<Vec<(Order, String)>>);

impl CommandQueue for FakeQueue {
    fn push(&self, order: Order, description: &str, answer: Answer) {
        self.0.lock().unwrap().push((order, description.to_owned()));
        send(
            answer,
            Reply {
                tick: Some(7),
                ..Reply::done()
            },
        );
    }
}

/// A recording of ten seconds; its frames contain their time.
struct FakePast;

impl PastReader for FakePast {
    fn frame(&mut self, target: SeekTarget) -> Result<Vec<u8>, String> {
        if target.time_s > 10.0 {
            return Err("not recorded".to_owned());
        }
        Ok(format!("past {}", target.time_s).into_bytes())
    }

    fn message(&mut self, target: SeekTarget) -> Value {
        json!({ "t": "past", "time_s": target.time_s, "epoch": target.epoch })
    }

    fn frames(&mut self, span: &PastSpan) -> Result<Vec<u8>, String> {
        let times = span.times_s().map(|time_s| time_s.to_string());
        Ok(times.collect::<Vec<_>>().join(" ").into_bytes())
    }
}

pub struct Bench {
    pub broadcast: Arc<Broadcast>,
    pub queue: Arc<FakeQueue>,
    pub address: SocketAddr,
    server: Option<std::thread::JoinHandle<()>>,
    /// Of incidents: number 3 is there.
    _kept: tempfile::TempDir,
}

fn hello(live: bool) -> Hello {
    Hello {
        live,
        run: RunInfo {
            id: "1".to_owned(),
            cell: "c".to_owned(),
            command: String::new(),
            demo: "d".to_owned(),
            policy: "p".to_owned(),
            seed: 1,
            speed: "1".to_owned(),
        },
        demos: Vec::new(),
        source: None,
    }
}

/// The grasps of object 1 by arm 0, and its joints.
fn search(search: Search) -> Result<String, String> {
    match search {
        Search::Grasps(0, 1) => Ok(r#"{"arm":"panda"}"#.to_owned()),
        Search::Joints(0, pose) => Ok(format!(r#"{{"joints":[{}]}}"#, pose[2])),
        Search::Grasps(arm, _) | Search::Joints(arm, _) => Err(format!("there is no arm {arm}")),
    }
}

impl Bench {
    pub fn start() -> Self {
        Self::with(Files::default(), true)
    }

    pub fn with(files: Files, live: bool) -> Self {
        Self::serve(files, live, |access| access)
    }

    pub fn with_one_time_links(file: &Path) -> Self {
        let file = file.to_owned();
        Self::serve(Files::default(), true, |access| {
            access.with_one_time_links(file)
        })
    }

    pub fn with_host(name: &str) -> Self {
        let name = Some(name.to_owned());
        Self::serve(Files::default(), true, |access| access.with_host(name))
    }

    fn serve(
        files: Files,
        live: bool,
        set_up: impl FnOnce(AccessControl) -> AccessControl + Send + 'static,
    ) -> Self {
        let name = "<script>alert(1)</script>";
        let kept = tempfile::tempdir().unwrap();
        let incidents = Incidents::at(kept.path().to_owned());
        std::fs::create_dir(incidents.path(3)).unwrap();
        std::fs::write(incidents.path(3).join("incident.json"), "what was kept").unwrap();
        let hello = hello(live);
        let scene = json!({ "demo": "d", "objects": [{ "name": name }] });
        let past: OpenPast = Arc::new(|| Ok(Box::new(FakePast)));
        let queue = Arc::new(FakeQueue::default());
        let (send_address, address) = std::sync::mpsc::channel();
        let broadcast = Broadcast::new(hello, scene);
        let (source, commands) = (broadcast.clone(), queue.clone());
        let server = std::thread::spawn(move || {
            let runtime = tokio::runtime::Builder::new_current_thread()
                .enable_all()
                .build()
                .unwrap();
            runtime.block_on(async {
                let listening = bind("127.0.0.1:0".parse().unwrap()).await.unwrap();
                send_address.send(listening.address()).unwrap();
                let services = Services {
                    access: set_up(AccessControl::new(listening.address(), secrets())),
                    files,
                    meshes: Files::default(),
                    hint: "install <Node>".to_owned(),
                    broadcast: source.clone(),
                    queue: commands,
                    names: Names {
                        objects: vec!["red_cube".to_owned(), name.to_owned()],
                        arms: 1,
                    },
                    policies: None,
                    past,
                    search: live.then(|| Arc::new(search) as SearchOf),
                    incidents: if live {
                        KeptIncidents::Live(incidents)
                    } else {
                        KeptIncidents::Recorded([(7, b"of a recording".to_vec())].into())
                    },
                };
                tokio::select! {
                    served = listening.serve(services) => served.unwrap(),
                    () = source.closed() => tokio::time::sleep(Duration::from_millis(100)).await,
                }
            });
        });
        Self {
            broadcast,
            queue,
            address: address.recv().unwrap(),
            server: Some(server),
            _kept: kept,
        }
    }

    pub fn host(&self) -> String {
        format!("localhost:{}", self.address.port())
    }

    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// Sends `head` and `body` unchanged; returns the whole answer.
    pub fn raw(&self, head: &str, body: &str) -> String {
        let mut stream = self.connect();
        let length = body.len();
        let text = format!("{head}Connection: close\r\nContent-Length: {length}\r\n\r\n{body}");
        stream.write_all(text.as_bytes()).unwrap();
        let mut answer = Vec::new();
        // A refused connection may be reset after its answer.
        let _read = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }

    /// `GET path` with more header lines.
    pub fn get(&self, path: &str, lines: &str) -> String {
        let host = self.host();
        self.raw(
            &format!("GET {path} HTTP/1.1\r\nHost: {host}\r\n{lines}"),
            "",
        )
    }

    pub fn post(&self, path: &str, lines: &str, body: &str) -> String {
        let host = self.host();
        let head = format!(
            "POST {path} HTTP/1.1\r\nHost: {host}\r\nContent-Type: application/json\r\n{lines}"
        );
        self.raw(&head, body)
    }

    /// The cookie line for a token.
    pub fn cookie(&self, token: &str) -> String {
        let answer = self.get(&format!("/?token={token}"), "");
        let line = answer
            .lines()
            .find(|l| l.starts_with("set-cookie: "))
            .unwrap();
        let pair = line["set-cookie: ".len()..].split(';').next().unwrap();
        format!("Cookie: {pair}\r\n")
    }

    /// Opens a websocket like a program, or returns the status of the refusal.
    pub fn socket(&self, token: &str) -> Result<Socket, u16> {
        self.upgrade(&[("authorization", &format!("Bearer {token}"))])
    }

    pub fn upgrade(&self, lines: &[(&'static str, &str)]) -> Result<Socket, u16> {
        let url = format!("ws://{}/ws", self.host());
        let mut request = url.into_client_request().unwrap();
        for (name, value) in lines {
            request.headers_mut().insert(*name, value.parse().unwrap());
        }
        match tungstenite::client(request, self.connect()) {
            Ok((socket, _)) => Ok(socket),
            Err(tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer))) => {
                Err(answer.status().as_u16())
            }
            Err(other) => panic!("{other}"),
        }
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        self.broadcast.close("end");
        if let Some(server) = self.server.take() {
            let joined = server.join();
            assert!(
                joined.is_ok() || std::thread::panicking(),
                "the server panicked"
            );
        }
    }
}

fn secrets() -> PageSecrets {
    PageSecrets {
        operator_token: OPERATOR.to_owned(),
        viewer_token: VIEWER.to_owned(),
        operator_cookie: "c".repeat(32),
        viewer_cookie: "d".repeat(32),
    }
}

/// Status code of an answer.
pub fn status(answer: &str) -> u16 {
    let code = answer.split(' ').nth(1).unwrap_or_default();
    code.parse().unwrap_or(0)
}

/// The next text of kind `t`.
pub fn text(socket: &mut Socket, t: &str) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            let value: Value = serde_json::from_str(text.as_str()).unwrap();
            if value["t"] == t {
                return value;
            }
        }
    }
}

/// The next binary frame.
pub fn frame(socket: &mut Socket) -> Vec<u8> {
    loop {
        if let Message::Binary(frame) = socket.read().unwrap() {
            return frame.to_vec();
        }
    }
}

/// Sends `command` and waits for its answer.
pub fn ask(socket: &mut Socket, command: &str) -> Value {
    socket.send(Message::text(command)).unwrap();
    let sent: Value = serde_json::from_str(command).unwrap_or_default();
    let id = sent["id"].as_u64().unwrap_or(0);
    loop {
        let ack = text(socket, "ack");
        if ack["id"] == id {
            return ack;
        }
    }
}

/// Reads to the end; returns the closing message, if there was one.
pub fn closing(socket: &mut Socket) -> Option<String> {
    let mut word = None;
    while let Ok(message) = socket.read() {
        if let Message::Text(text) = message {
            let value: Value = serde_json::from_str(text.as_str()).unwrap();
            if value["t"] == "gone" {
                word = value["what"].as_str().map(str::to_owned);
            }
        }
    }
    word
}
