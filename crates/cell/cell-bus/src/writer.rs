//! The writing port of a topic, and of its tap.

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
