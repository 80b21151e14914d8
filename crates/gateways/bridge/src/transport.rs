//! Interface of the bridge to the network.

use std::path::PathBuf;

use thiserror::Error;

use crate::endpoints::{NamedCommand, Stream};
use crate::ros::attachment::Attachment;

/// Reasons why the network cannot be used.
#[derive(Debug, Error)]
pub enum TransportError {
    /// The network library.
    #[error("cannot {what}: {reason}")]
    Network {
        /// The operation.
        what: String,
        /// Reason of the failure.
        reason: String,
    },
    /// The token.
    #[error("the token file {path} {reason}; create it with: (umask 077; openssl rand -hex 24 > {path})", path = path.display())]
    Token {
        /// The file.
        path: PathBuf,
        /// Description of the defect.
        reason: String,
    },
}

/// Sends the answer to a service request.
pub type Reply = Box<dyn FnOnce(Vec<u8>) + Send>;

/// A command received from the network.
pub struct Arrived {
    /// Index of the command in the offer.
    pub index: usize,
    /// The message.
    pub payload: Vec<u8>,
    /// Attachment of its sender.
    pub attachment: Option<Attachment>,
    /// Whether its sender has proved to know the token.
    pub may_command: bool,
    /// Answers the request of a service.
    pub reply: Option<Reply>,
}

/// Operations of the network for the bridge. None of them waits for a client.
pub trait Transport {
    /// Offers streams and commands, replacing the former offer.
    ///
    /// # Errors
    /// If the network refuses a name.
    fn offer(
        &mut self,
        streams: &[Stream],
        commands: &[NamedCommand],
    ) -> Result<(), TransportError>;

    /// Sends a message that was made at `source_ns` (since 1970). A message that cannot be sent
    /// at once is dropped.
    fn publish(&mut self, stream: Stream, payload: &[u8], source_ns: i64);

    /// The oldest waiting command.
    fn next_command(&mut self) -> Option<Arrived>;

    /// Commands that were dropped because too many waited.
    fn dropped(&self) -> u64;
}
