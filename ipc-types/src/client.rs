//! Input of an arm's client program, for the recorder.

use crate::header::Header;
use crate::validate::{Check, Invalid, Validate, code};
use crate::wire::wire;

/// Bytes of a client that a [`ClientInput`] has room for: the longest request.
pub const CLIENT_BYTES: usize = 512;

code! {
    /// Kind of a [`ClientInput`].
    pub enum ClientEvent {
        /// Nothing was received; states were sent again.
        None = 0,
        /// A client of the arm has connected.
        Connected = 1,
        /// A request to the arm.
        Request = 2,
        /// A command of a motion, which answers a state.
        Command = 3,
        /// The connection to the arm has ended.
        Ended = 4,
        /// A request to the hand.
        HandRequest = 5,
        /// The connection to the hand has ended.
        HandEnded = 6,
    }
}

wire! {
    /// One input of the client program that commands an arm over the network, as its control
    /// interface has taken it. The header names the state that was the newest one by then.
    pub struct ClientInput {
        /// Header.
        pub header: Header,
        /// Which arm of the cell, by its place in the cell file.
        pub arm: u32,
        /// [`ClientEvent`].
        pub event: u32,
        /// States that were sent again since the input before, without a cycle.
        pub repeats: u32,
        /// 1 where simulated time waits for the client, so that no command is late.
        pub is_awaited: u32,
        /// Valid entries of `bytes`.
        pub len: u32,
        /// Zero.
        pub reserved: u32,
        /// The request or the command, as received.
        pub bytes: [u8; CLIENT_BYTES],
    }
}

impl ClientInput {
    /// The received bytes.
    pub fn bytes(&self) -> &[u8] {
        // Bounded here as well: one from a recording may be read before it is validated.
        &self.bytes[..(self.len as usize).min(CLIENT_BYTES)]
    }
}

impl Validate for ClientInput {
    fn validate(&self) -> Result<(), Invalid> {
        Check::code(
            "event",
            self.event,
            ClientEvent::from_code(self.event).is_some(),
        )?;
        Check::count("len", self.len, CLIENT_BYTES)
    }
}
