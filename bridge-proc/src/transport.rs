//! The network, as the bridge sees it.

use std::path::PathBuf;

use thiserror::Error;

use crate::endpoints::{NamedCommand, Stream};
use crate::ros::attachment::Attachment;

/// Why the network cannot be used.
#[derive(Debug, Error)]
pub enum TransportError {
    /// The network library.
    #[error("cannot {what}: {reason}")]
    Network {
        /// What it was asked for.
        what: String,
        /// Why it failed.
        reason: String,
    },
    /// The token.
    #[error("the token file {path} {reason}; create it with: (umask 077; openssl rand -hex 24 > {path})", path = path.display())]
    Token {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
}

/// Sends what answers a service request.
pub type Reply = Box<dyn FnOnce(Vec<u8>) + Send>;

/// A command that came from the network.
pub struct Arrived {
    /// Which, by its place in what was offered.
    pub index: usize,
    /// The message.
    pub payload: Vec<u8>,
    /// What its sender says about it.
    pub attachment: Option<Attachment>,
    /// Whether its sender has proved to know the token.
    pub may_command: bool,
    /// Answers the request of a service.
    pub reply: Option<Reply>,
}

/// What the network has to do for the bridge. Nothing in it waits for a client.
pub trait Transport {
    /// Offers streams and commands, in the place of what was offered before.
    ///
    /// # Errors
    /// Where the network refuses a name.
    fn offer(
        &mut self,
        streams: &[Stream],
        commands: &[NamedCommand],
    ) -> Result<(), TransportError>;

    /// Sends a message that was made at `source_ns` (since 1970). One that cannot be sent at
    /// once is dropped.
    fn publish(&mut self, stream: Stream, payload: &[u8], source_ns: i64);

    /// The oldest command that waits.
    fn next_command(&mut self) -> Option<Arrived>;

    /// Commands that were dropped because too many waited.
    fn dropped(&self) -> u64;
}
