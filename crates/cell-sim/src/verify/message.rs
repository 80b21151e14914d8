//! What a recording holds, one message at a time.

use ipc_types::topic::Process;
use ipc_types::{ArmCommand, ArmStatus, Decision, Keyframe, WorldPiece};

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
    /// What a process remembered.
    Keyframe(Process, Box<Keyframe>),
}

/// The messages of a recording one after the other, and in between why some
/// cannot be read.
pub type Messages<'a> = Box<dyn Iterator<Item = Result<Message, String>> + 'a>;

/// Something recorded, which can be read more than once. Messages of one topic
/// come in the order they were sent; those of different topics in any order.
pub trait Recorded {
    /// All messages, from the first on.
    fn messages(&self) -> Messages<'_>;
}

impl Recorded for [Message] {
    fn messages(&self) -> Messages<'_> {
        Box::new(self.iter().cloned().map(Ok))
    }
}
