//! The recorded messages that verification reads.

use ipc_types::topic::Process;
use ipc_types::{ArmCommand, ArmStatus, ClientInput, Decision, Keyframe, WorldPiece};

/// A recorded message, as it was sent.
#[derive(Clone, Debug)]
pub enum Message {
    /// Part of a state.
    World(Box<WorldPiece>),
    /// Command of an arm.
    Command(u8, Box<ArmCommand>),
    /// Status of an arm.
    Status(u8, Box<ArmStatus>),
    /// Decision of the task.
    Decision(Box<Decision>),
    /// Input of the client of an arm.
    Client(u8, Box<ClientInput>),
    /// Part of the memory of a process.
    Keyframe(Process, Box<Keyframe>),
}

/// The messages of a recording in order. An `Err` is the reason for which one cannot be read;
/// later messages may follow.
pub type Messages<'a> = Box<dyn Iterator<Item = Result<Message, String>> + 'a>;

/// A recorded run that can be read more than once. Messages of one topic are in the order in
/// which they were sent; those of different topics may be in any order.
pub trait Recorded {
    /// All messages, starting with the first.
    fn messages(&self) -> Messages<'_>;
}

impl Recorded for [Message] {
    fn messages(&self) -> Messages<'_> {
        Box::new(self.iter().cloned().map(Ok))
    }
}
