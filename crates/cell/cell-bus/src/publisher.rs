//! The writer of a topic.
//!
//! What can go wrong: a reader is stopped, killed or slow. The rule: a publisher never waits
//! for a reader, neither in `send` nor for memory; what a reader misses is the oldest, and it
//! sees the gap in the sequence numbers. A change must not block here: with the transport's
//! default strategy one send to a stopped reader took 2.0 s, and one to a killed reader 3.06 s.

use ipc_types::header::Header;

use crate::bus::Bus;
use crate::error::{BusError, PublishError};
use crate::message::TopicMessage;
use crate::writer::Publish;

/// Sends messages that are written where their readers find them. Never blocks:
/// a reader that is behind loses the oldest.
#[derive(Debug)]
pub struct Publisher<T: TopicMessage>(Box<dyn Publish<T>>);

impl<T: TopicMessage> Publisher<T> {
    pub(crate) fn open(bus: &Bus, name: &str, tap: Option<&str>) -> Result<Self, BusError> {
        T::publish_on(bus, name, tap).map(Self)
    }

    /// Has `write` fill one message in place and sends it; returns its sequence
    /// number, from 1 up.
    ///
    /// The message holds what an earlier one left in the same place, or zeros,
    /// so `write` sets every field that counts. The header is fresh: `write`
    /// sets `tick`, `sim_time_ns` and inputs (a whole [`Header::caused_by`]
    /// does); schema, run, generation, seq and time are stamped afterwards.
    pub fn publish(&mut self, write: impl FnOnce(&mut T)) -> Result<u64, PublishError> {
        let mut write = Some(write);
        self.0.publish(&mut |message| {
            if let Some(write) = write.take() {
                write(message);
            }
        })
    }

    /// Sends a copy of `message`, stamped as by [`Self::publish`].
    pub fn publish_copy(&mut self, message: &T) -> Result<u64, PublishError> {
        self.0.publish(&mut |place| *place = *message)
    }

    /// Lets readers that joined since the last message in, also those of the tap, and gives
    /// them the newest messages. A writer that publishes rarely or waits for others calls this
    /// every few milliseconds: otherwise a late reader gets nothing until the next message.
    pub fn update_connections(&mut self) {
        self.0.update_connections();
    }

    /// Sequence number of the last message sent, 0 before the first.
    pub fn seq(&self) -> u64 {
        self.0.header().seq
    }

    /// Header of the last message sent; zeros before the first.
    pub fn header(&self) -> &Header {
        self.0.header()
    }

    /// Messages that were not sent.
    pub fn errors(&self) -> u64 {
        self.0.errors()
    }
}
