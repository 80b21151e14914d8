//! Executes the commands of pages in a live cell: physics over the bus, the launcher over its
//! socket, the recorder in this process. Physics and the others have a thread each, so that a
//! restart does not delay a drag.
//!
//! `push` never waits, as it runs on the thread that serves all pages: a full queue refuses the
//! command instead. Every command gets exactly one answer.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::sync::mpsc;
use std::time::Duration;

use cell_bus::{Bus, OperatorClient};
use cell_worker::Start;
use ipc_types::OperatorRequest;
use ipc_types::operator::ReplyCode;
use ipc_types::topic::Process;
use serde::Deserialize;
use serde_json::Value;

use crate::page::command::{Order, RecordOrder};
use crate::page::queue::{Answer, CommandQueue, Reply, send};

/// Commands waiting, of all pages.
// 16 pages with eight commands each.
const WAITING: usize = 128;
/// Physics answers within a tick; a busy machine needs longer.
const PHYSICS_PATIENCE: Duration = Duration::from_secs(2);
/// Time in which a demo is loaded and a process started.
const LAUNCHER_PATIENCE: Duration = Duration::from_secs(10);
/// Longest answer of the launcher (bytes).
// One line; a longer one is not from our launcher.
const MAX_ANSWER: u64 = 1 << 16;

/// A request for physics.
pub type PhysicsRequest = (Box<OperatorRequest>, Answer);
/// A request for the launcher or the recorder.
pub type QueuedControl = (ControlRequest, Answer);

/// Requests to processes other than physics.
#[derive(Clone, Debug, PartialEq)]
pub enum ControlRequest {
    /// A line for the launcher.
    Launch(Value),
    /// For the recorder.
    Record(RecordOrder),
}

/// Sorts commands by recipient and has each written to the log.
pub struct LiveCommandQueue {
    physics: mpsc::SyncSender<PhysicsRequest>,
    control: mpsc::SyncSender<QueuedControl>,
    log: mpsc::Sender<String>,
}

/// Receiving ends of the queue.
pub struct Receivers {
    /// For [`serve_physics`].
    pub physics: mpsc::Receiver<PhysicsRequest>,
    /// For [`serve_control`].
    pub control: mpsc::Receiver<QueuedControl>,
    /// Descriptions for the log.
    pub log: mpsc::Receiver<String>,
}

impl LiveCommandQueue {
    /// A queue and its receiving ends.
    pub fn new() -> (Self, Receivers) {
        let (physics, at_physics) = mpsc::sync_channel(WAITING);
        let (control, at_control) = mpsc::sync_channel(WAITING);
        let (log, at_log) = mpsc::channel();
        let queue = Self {
            physics,
            control,
            log,
        };
        let receivers = Receivers {
            physics: at_physics,
            control: at_control,
            log: at_log,
        };
        (queue, receivers)
    }
}

impl CommandQueue for LiveCommandQueue {
    fn push(&self, order: Order, description: &str, answer: Answer) {
        // Without a log there is no reader, which does not matter for the command.
        let _written = self.log.send(description.to_owned()).is_ok();
        // The answer comes back with a refused command, so it can be sent in any case.
        let left = match order {
            Order::Operate(request) => not_accepted(self.physics.try_send((request, answer))),
            Order::Launch(line) => not_accepted(
                self.control
                    .try_send((ControlRequest::Launch(line), answer)),
            ),
            Order::Record(order) => not_accepted(
                self.control
                    .try_send((ControlRequest::Record(order), answer)),
            ),
            Order::Play(_) => Some((answer, "this cell is live: there is nothing to replay")),
        };
        if let Some((answer, why)) = left {
            send(answer, Reply::refused(why));
        }
    }
}

/// The answer of a command that was not accepted, and the reason.
fn not_accepted<T>(
    sent: Result<(), mpsc::TrySendError<(T, Answer)>>,
) -> Option<(Answer, &'static str)> {
    match sent {
        Ok(()) => None,
        Err(mpsc::TrySendError::Full((_, answer))) => {
            Some((answer, "too many commands wait; try again"))
        }
        Err(mpsc::TrySendError::Disconnected((_, answer))) => {
            Some((answer, "the monitor is ending"))
        }
    }
}

/// Sends requests to physics until the queue is dropped.
pub fn serve_physics(start: &Start, orders: &mpsc::Receiver<PhysicsRequest>) {
    let mut connection = PhysicsConnection::default();
    while let Ok((request, answer)) = orders.recv() {
        let reply = connection.ask(start, &request);
        send(answer, reply);
    }
}

/// The connection to physics, made when it is needed.
#[derive(Default)]
struct PhysicsConnection {
    // A port must not outlive its node.
    // In this order: a port is closed before its bus.
    client: Option<OperatorClient>,
    bus: Option<Bus>,
}

impl PhysicsConnection {
    fn ask(&mut self, start: &Start, request: &OperatorRequest) -> Reply {
        let client = match self.client(start) {
            Ok(client) => client,
            Err(why) => return Reply::refused(why),
        };
        match client.request(*request, PHYSICS_PATIENCE) {
            Err(error) => Reply::refused(error.to_string()),
            Ok(reply) => Reply {
                ok: reply.code == ReplyCode::Accepted.code(),
                tick: Some(reply.header.tick),
                message: reply.message.as_str().to_owned(),
            },
        }
    }

    fn client(&mut self, start: &Start) -> Result<&mut OperatorClient, String> {
        // At the first request: a cell without commands needs no second node.
        if self.client.is_none() {
            // The bus is kept if only the client failed, as joining is the costly part.
            let bus = match self.bus.take() {
                Some(bus) => bus,
                None => start
                    .join(Process::Monitor)
                    .map_err(|error| error.to_string())?,
            };
            let client = bus.operator_client();
            self.bus = Some(bus);
            self.client = Some(client.map_err(|error| error.to_string())?);
        }
        self.client
            .as_mut()
            .ok_or_else(|| "not connected to physics".to_owned())
    }
}

/// Executes requests until the queue is dropped; `record` passes them to the recorder.
pub fn serve_control(
    socket: &Path,
    control: &mpsc::Receiver<QueuedControl>,
    mut record: impl FnMut(RecordOrder) -> Result<String, String>,
) {
    while let Ok((request, answer)) = control.recv() {
        let reply = match request {
            ControlRequest::Launch(line) => ask_launcher(socket, &line),
            ControlRequest::Record(order) => match record(order) {
                Ok(message) => Reply {
                    message,
                    ..Reply::done()
                },
                Err(why) => Reply::refused(why),
            },
        };
        send(answer, reply);
    }
}

#[derive(Deserialize)]
struct LauncherReply {
    ok: bool,
    message: String,
}

fn ask_launcher(socket: &Path, line: &Value) -> Reply {
    let talk = || -> io::Result<LauncherReply> {
        let mut stream = UnixStream::connect(socket)?;
        // The launcher may be busy with a start; without a limit all later commands would wait.
        stream.set_read_timeout(Some(LAUNCHER_PATIENCE))?;
        stream.set_write_timeout(Some(LAUNCHER_PATIENCE))?;
        writeln!(stream, "{line}")?;
        let mut answer = String::new();
        BufReader::new(stream.take(MAX_ANSWER)).read_line(&mut answer)?;
        Ok(serde_json::from_str(&answer)?)
    };
    match talk() {
        Ok(reply) => Reply {
            ok: reply.ok,
            tick: None,
            message: reply.message,
        },
        Err(error) => Reply::refused(format!("the launcher does not answer: {error}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::net::UnixListener;
    use tokio::sync::oneshot;

    #[test]
    fn a_restart_reaches_the_launcher_and_its_refusal_the_page() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("control.sock");
        let listener = UnixListener::bind(&path).unwrap();
        let launcher = std::thread::spawn(move || {
            let (stream, _) = listener.accept().unwrap();
            let mut line = String::new();
            BufReader::new(&stream).read_line(&mut line).unwrap();
            let mut stream = stream;
            writeln!(stream, r#"{{"ok": false, "message": "not now"}}"#).unwrap();
            line
        });
        let (queue, receivers) = LiveCommandQueue::new();
        let (answer, mut reply) = oneshot::channel();
        let line = serde_json::json!({ "ask": "restart", "process": "task" });
        queue.push(Order::Launch(line.clone()), "restart task", answer);
        drop(queue);
        serve_control(&path, &receivers.control, |_| Err("no recorder".to_owned()));
        assert_eq!(reply.try_recv().unwrap(), Reply::refused("not now"));
        assert_eq!(receivers.log.recv().unwrap(), "restart task");
        assert_eq!(launcher.join().unwrap(), format!("{line}\n"));
    }

    #[test]
    fn a_command_too_many_is_refused_at_once() {
        let (queue, _counters) = LiveCommandQueue::new();
        let mut replies = Vec::new();
        for _ in 0..=WAITING {
            let (answer, reply) = oneshot::channel();
            queue.push(Order::Record(RecordOrder::Stop), "record stop", answer);
            replies.push(reply);
        }
        let last = replies.last_mut().unwrap().try_recv().unwrap();
        assert!(!last.ok && last.message.contains("too many"), "{last:?}");
        assert!(replies[0].try_recv().is_err(), "still waits");
    }
}
