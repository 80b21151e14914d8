//! What a recording holds, one message at a time.

use ipc_types::topic::Process;
use ipc_types::{ArmCommand, ArmStatus, Decision, Keyframe, WorldPiece};

use super::VerifyError;

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

/// The messages of a recording one after the other.
pub type Messages<'a> = Box<dyn Iterator<Item = Result<Message, VerifyError>> + 'a>;

/// Something recorded, which can be read more than once. Messages of one topic
/// come in the order they were sent; those of different topics in any order.
pub trait Recorded {
    /// All messages, from the first on.
    ///
    /// # Errors
    /// [`VerifyError`] where the recording cannot be read.
    fn messages(&self) -> Result<Messages<'_>, VerifyError>;
}

impl Recorded for [Message] {
    fn messages(&self) -> Result<Messages<'_>, VerifyError> {
        Ok(Box::new(self.iter().cloned().map(Ok)))
    }
}
