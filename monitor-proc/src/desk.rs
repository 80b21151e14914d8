//! Executes the commands of pages in a live cell: physics over the bus, the launcher over its
//! socket, the recorder in this process. Physics and the others have a thread each, so that a
//! restart does not delay a drag.
//!
//! `take` never waits, as it runs on the thread that serves all pages: a full queue refuses the
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
use crate::page::desk::{Answer, Desk, Reply, send};

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
pub type PhysicsErrand = (Box<OperatorRequest>, Answer);
/// A request for the launcher or the recorder.
pub type Errand = (ErrandKind, Answer);

/// Requests to processes other than physics.
#[derive(Clone, Debug, PartialEq)]
pub enum ErrandKind {
    /// A line for the launcher.
    Launch(Value),
    /// For the recorder.
    Record(RecordOrder),
}

/// Sorts commands by recipient and has each written to the journal.
pub struct LiveDesk {
    physics: mpsc::SyncSender<PhysicsErrand>,
    errands: mpsc::SyncSender<Errand>,
    journal: mpsc::Sender<String>,
}

/// Receiving ends of the desk.
pub struct Counters {
    /// For [`serve_physics`].
    pub physics: mpsc::Receiver<PhysicsErrand>,
    /// For [`serve_errands`].
    pub errands: mpsc::Receiver<Errand>,
    /// For the journal.
    pub journal: mpsc::Receiver<String>,
}

impl LiveDesk {
    /// A desk and its receiving ends.
    pub fn new() -> (Self, Counters) {
        let (physics, at_physics) = mpsc::sync_channel(WAITING);
        let (errands, at_errands) = mpsc::sync_channel(WAITING);
        let (journal, at_journal) = mpsc::channel();
        let desk = Self {
            physics,
            errands,
            journal,
        };
        let counters = Counters {
            physics: at_physics,
            errands: at_errands,
            journal: at_journal,
        };
        (desk, counters)
    }
}

impl Desk for LiveDesk {
    fn take(&self, order: Order, said: &str, answer: Answer) {
        // Without a journal there is no reader, which does not matter for the command.
        let _written = self.journal.send(said.to_owned()).is_ok();
        // The answer comes back with a refused command, so it can be sent in any case.
        let left = match order {
            Order::Operate(request) => over(self.physics.try_send((request, answer))),
            Order::Launch(line) => over(self.errands.try_send((ErrandKind::Launch(line), answer))),
            Order::Record(order) => {
                over(self.errands.try_send((ErrandKind::Record(order), answer)))
            }
            Order::Play(_) => Some((answer, "this cell is live: there is nothing to replay")),
        };
        if let Some((answer, why)) = left {
            send(answer, Reply::refused(why));
        }
    }
}

/// The answer of a command that was not accepted, and the reason.
fn over<T>(sent: Result<(), mpsc::TrySendError<(T, Answer)>>) -> Option<(Answer, &'static str)> {
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

/// Sends requests to physics until the desk is dropped.
pub fn serve_physics(start: &Start, orders: &mpsc::Receiver<PhysicsErrand>) {
    let mut line = Line::default();
    while let Ok((request, answer)) = orders.recv() {
        let reply = line.ask(start, &request);
        send(answer, reply);
    }
}

/// The connection to physics, made when it is needed.
#[derive(Default)]
struct Line {
    // A port must not outlive its node.
    // In this order: a port is closed before its bus.
    client: Option<OperatorClient>,
    bus: Option<Bus>,
}

impl Line {
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

/// Executes requests until the desk is dropped; `record` passes them to the recorder.
pub fn serve_errands(
    control: &Path,
    errands: &mpsc::Receiver<Errand>,
    mut record: impl FnMut(RecordOrder) -> Result<String, String>,
) {
    while let Ok((errand, answer)) = errands.recv() {
        let reply = match errand {
            ErrandKind::Launch(line) => ask_launcher(control, &line),
            ErrandKind::Record(order) => match record(order) {
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

fn ask_launcher(control: &Path, line: &Value) -> Reply {
    let talk = || -> io::Result<LauncherReply> {
        let mut stream = UnixStream::connect(control)?;
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
        let (desk, counters) = LiveDesk::new();
        let (answer, mut reply) = oneshot::channel();
        let line = serde_json::json!({ "ask": "restart", "process": "task" });
        desk.take(Order::Launch(line.clone()), "restart task", answer);
        drop(desk);
        serve_errands(&path, &counters.errands, |_| Err("no recorder".to_owned()));
        assert_eq!(reply.try_recv().unwrap(), Reply::refused("not now"));
        assert_eq!(counters.journal.recv().unwrap(), "restart task");
        assert_eq!(launcher.join().unwrap(), format!("{line}\n"));
    }

    #[test]
    fn a_command_too_many_is_refused_at_once() {
        let (desk, _counters) = LiveDesk::new();
        let mut replies = Vec::new();
        for _ in 0..=WAITING {
            let (answer, reply) = oneshot::channel();
            desk.take(Order::Record(RecordOrder::Stop), "record stop", answer);
            replies.push(reply);
        }
        let last = replies.last_mut().unwrap().try_recv().unwrap();
        assert!(!last.ok && last.message.contains("too many"), "{last:?}");
        assert!(replies[0].try_recv().is_err(), "still waits");
    }
}
