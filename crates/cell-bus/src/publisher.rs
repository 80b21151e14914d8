//! The writer of a topic.
//!
//! What can go wrong: a reader is stopped, killed or slow. The rule: a publisher never waits
//! for a reader, neither in `send` nor for memory; what a reader misses is the oldest, and it
//! sees the gap in the sequence numbers. A change must not block here: with the transport's
//! default strategy one send to a stopped reader took 2.0 s, and one to a killed reader 3.06 s.

use cell_rt::monotonic_ns;
use iceoryx2::port::LoanError;
use iceoryx2::port::publisher::Publisher as Port;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use ipc_types::Wire as _;
use ipc_types::header::{Header, Message};

use crate::bus::Bus;
use crate::error::{BusError, PublishError};
use crate::identity::Identity;
use crate::message::TopicMessage;

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
pub(crate) struct Writer<T: Message> {
    port: Port<ipc::Service, T, ()>,
    /// Copies of all that is sent, for a recorder.
    tap: Option<Port<ipc::Service, T, ()>>,
    identity: Identity,
    /// Of the newest message.
    header: Header,
    errors: u64,
}

impl<T: Message> Writer<T> {
    /// `tap` is the topic that gets a copy of every message.
    pub(crate) fn open(bus: &Bus, name: &str, tap: Option<&str>) -> Result<Self, BusError> {
        let open = |name: &str| port(&bus.open_topic::<T>(name)?, name);
        Ok(Self {
            port: open(name)?,
            tap: tap.map(open).transpose()?,
            identity: bus.identity(),
            // The first message has number 1: 0 is the number in
            // zeroed memory, which the fence rejects.
            header: Header::zeroed(),
            errors: 0,
        })
    }

    fn try_publish(&mut self, write: &mut dyn FnMut(&mut T)) -> Result<u64, PublishError> {
        // In place, without a zeroed or copied message in between: a state has 20 kB.
        let mut sample = ipc_types::loan::loan(&self.port).map_err(PublishError::Loan)?;
        let message = sample.payload_mut();
        blank(message.header_mut());
        write(message);
        let header = message.header_mut();
        // Stamped after `write`, so that no caller can claim another identity or number.
        header.schema = T::SCHEMA;
        header.run = self.identity.run;
        header.generation = self.identity.generation;
        header.seq = self.header.seq + 1;
        header.publish_ns = monotonic_ns();
        // The header is kept for the caller; after `send` the place belongs to the readers.
        let stamped = *header;
        // The tap's copy is made before `send`, as the message is gone afterwards.
        let copy = self.tap.as_ref().map(|tap| copied(sample.payload(), tap));
        sample.send().map_err(PublishError::Send)?;
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

impl<T: Message> Publish<T> for Writer<T> {
    fn publish(&mut self, write: &mut dyn FnMut(&mut T)) -> Result<u64, PublishError> {
        let sent = self.try_publish(write);
        if sent.is_err() {
            self.errors += 1;
        }
        sent
    }

    fn update_connections(&mut self) {
        for port in [Some(&self.port), self.tap.as_ref()].into_iter().flatten() {
            self.errors += u64::from(port.update_connections().is_err());
        }
    }

    fn header(&self) -> &Header {
        &self.header
    }

    fn errors(&self) -> u64 {
        self.errors
    }
}

/// `message` in memory of another port.
fn copied<T: Message>(
    message: &T,
    port: &Port<ipc::Service, T, ()>,
) -> Result<SampleMut<ipc::Service, T, ()>, LoanError> {
    let mut copy = ipc_types::loan::loan(port)?;
    *copy.payload_mut() = *message;
    Ok(copy)
}

fn port<T: Message>(
    service: &PortFactory<ipc::Service, T, ()>,
    name: &str,
) -> Result<Port<ipc::Service, T, ()>, BusError> {
    service
        .publisher_builder()
        // Overflow makes room, so this never applies; blocking must not be
        // what happens if it ever does.
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(|error| BusError::Port {
            service: name.to_owned(),
            reason: format!("{error:?}"),
        })
}

/// Takes out of a header what its place held before. Inputs beyond the count
/// belong to no message, and stay: their cache line need not move to the readers.
fn blank(header: &mut Header) {
    header.tick = 0;
    header.sim_time_ns = 0;
    header.input_count = 0;
}
