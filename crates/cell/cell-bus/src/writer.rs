//! The writing port of a topic, and of its tap.

use core::fmt::Debug;

use ipc_types::Wire as _;
use ipc_types::header::{Header, Message};

use crate::error::{BusError, PublishError};
use crate::identity::Identity;

/// A writing port of one of the wirings.
pub(crate) trait Outlet: Debug {
    type Message: Message;
    type Loan: Loan<Self::Message>;

    /// A place for a message, which holds an earlier one or zeros.
    fn loan(&self) -> Result<Self::Loan, PublishError>;
    /// A copy of `message` to send. A port that no reader can be on need not copy.
    fn copy_of(&self, message: &Self::Message) -> Result<Self::Loan, PublishError> {
        let mut copy = self.loan()?;
        *copy.message() = *message;
        Ok(copy)
    }
    /// Lets readers in that joined; false if that failed.
    fn update_connections(&self) -> bool;
    /// Time for the stamp of a message.
    fn now_ns(&self) -> u64;
}

/// The place of one message.
pub(crate) trait Loan<T> {
    fn message(&mut self) -> &mut T;
    fn send(self) -> Result<(), PublishError>;
}

/// The writer of a topic, with the type of its port hidden.
#[doc(hidden)]
pub trait Publish<T>: core::fmt::Debug {
    /// `write` is called at most once.
    fn publish(&mut self, write: &mut dyn FnMut(&mut T)) -> Result<u64, PublishError>;
    fn update_connections(&mut self);
    fn header(&self) -> &Header;
    fn errors(&self) -> u64;
}

#[derive(Debug)]
pub(crate) struct Writer<O> {
    port: O,
    /// Copies of all that is sent, for a recorder.
    tap: Option<O>,
    identity: Identity,
    /// Of the newest message.
    header: Header,
    errors: u64,
}

impl<O: Outlet> Writer<O> {
    /// Opens the topic `name`, and `tap`, which gets a copy of every message.
    pub(crate) fn open(
        identity: Identity,
        name: &str,
        tap: Option<&str>,
        open: impl Fn(&str) -> Result<O, BusError>,
    ) -> Result<Self, BusError> {
        Ok(Self {
            port: open(name)?,
            tap: tap.map(open).transpose()?,
            identity,
            // The first message has number 1: 0 is the number in
            // zeroed memory, which the fence rejects.
            header: Header::zeroed(),
            errors: 0,
        })
    }

    fn try_publish(&mut self, write: &mut dyn FnMut(&mut O::Message)) -> Result<u64, PublishError> {
        // In place, without a zeroed or copied message in between: a state has 20 kB.
        let mut place = self.port.loan()?;
        let message = place.message();
        blank(message.header_mut());
        write(message);
        let header = message.header_mut();
        // Stamped after `write`, so that no caller can claim another identity or number.
        header.schema = O::Message::SCHEMA;
        header.run = self.identity.run;
        header.generation = self.identity.generation;
        header.seq = self.header.seq + 1;
        header.publish_ns = self.port.now_ns();
        // The header is kept for the caller; after `send` the place belongs to the readers.
        let stamped = *header;
        // The tap's copy is made before `send`, as the message is gone afterwards.
        let copy = self.tap.as_ref().map(|tap| tap.copy_of(place.message()));
        place.send()?;
        self.header = stamped;
        // The recorder's copy is sent last, and its loss is not
        // a failure of the topic (ADR 0012).
        match copy {
            Some(Ok(copy)) => self.errors += u64::from(copy.send().is_err()),
            Some(Err(_)) => self.errors += 1,
            None => {}
        }
        Ok(self.header.seq)
    }
}

impl<O: Outlet> Publish<O::Message> for Writer<O> {
    fn publish(&mut self, write: &mut dyn FnMut(&mut O::Message)) -> Result<u64, PublishError> {
        let sent = self.try_publish(write);
        if sent.is_err() {
            self.errors += 1;
        }
        sent
    }

    fn update_connections(&mut self) {
        for port in [Some(&self.port), self.tap.as_ref()].into_iter().flatten() {
            self.errors += u64::from(!port.update_connections());
        }
    }

    fn header(&self) -> &Header {
        &self.header
    }

    fn errors(&self) -> u64 {
        self.errors
    }
}

/// Takes out of a header what its place held before. Inputs beyond the count
/// belong to no message, and stay: their cache line need not move to the readers.
fn blank(header: &mut Header) {
    header.tick = 0;
    header.sim_time_ns = 0;
    header.input_count = 0;
}
