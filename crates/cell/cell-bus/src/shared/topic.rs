//! Ports of topics of iceoryx2.

use cell_rt::monotonic_ns;
use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::port::update_connections::UpdateConnections as _;
use iceoryx2::prelude::{BackpressureStrategy, PortFactory as _, ipc};
use iceoryx2::sample::Sample;
use iceoryx2::sample_mut::SampleMut;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use ipc_types::header::Message;

use super::cause::{no_place, port_error};
use crate::error::{BusError, PublishError};
use crate::reader::{self, NoConnection};
use crate::site::RunSite;
use crate::writer::{self, Loan};

/// A publisher.
#[derive(Debug)]
pub(crate) struct Outlet<T: Message>(Publisher<ipc::Service, T, ()>);

impl<T: Message> Outlet<T> {
    pub(super) fn new(
        service: &PortFactory<ipc::Service, T, ()>,
        name: &str,
        site: &RunSite,
    ) -> Result<Self, BusError> {
        let limit = service.static_config().max_publishers();
        let port = service
            .publisher_builder()
            // Overflow makes room, so this never applies; blocking must not be
            // what happens if it ever does.
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(|error| match error {
                PublisherCreateError::ExceedsMaxSupportedPublishers => {
                    no_place(name, "writers", limit)
                }
                error => port_error(name, error, site),
            })?;
        Ok(Self(port))
    }
}

impl<T: Message> writer::Outlet for Outlet<T> {
    type Message = T;
    type Loan = SampleMut<ipc::Service, T, ()>;

    fn loan(&self) -> Result<Self::Loan, PublishError> {
        ipc_types::loan::loan(&self.0).map_err(PublishError::Loan)
    }

    fn update_connections(&self) -> bool {
        self.0.update_connections().is_ok()
    }

    fn now_ns(&self) -> u64 {
        monotonic_ns()
    }
}

impl<T: Message> Loan<T> for SampleMut<ipc::Service, T, ()> {
    fn message(&mut self) -> &mut T {
        self.payload_mut()
    }

    fn send(self) -> Result<(), PublishError> {
        Self::send(self).map(|_| ()).map_err(PublishError::Send)
    }
}

/// A subscriber.
#[derive(Debug)]
pub(crate) struct Inlet<T: Message> {
    port: Subscriber<ipc::Service, T, ()>,
    service: PortFactory<ipc::Service, T, ()>,
    /// Messages of one writer that can wait.
    depth: usize,
}

impl<T: Message> Inlet<T> {
    pub(super) fn new(
        service: PortFactory<ipc::Service, T, ()>,
        name: &str,
        site: &RunSite,
    ) -> Result<Self, BusError> {
        let limit = service.static_config().max_subscribers();
        let port = service.subscriber_builder().create();
        let port = port.map_err(|error| match error {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => {
                no_place(name, "readers", limit)
            }
            error => port_error(name, error, site),
        })?;
        Ok(Self {
            depth: port.buffer_size(),
            port,
            service,
        })
    }
}

impl<T: Message> reader::Inlet for Inlet<T> {
    type Message = T;
    type Sample = Sample<ipc::Service, T, ()>;

    fn receive(&mut self) -> Result<Option<(u128, Self::Sample)>, NoConnection> {
        let received = self.port.receive().map_err(|_| NoConnection)?;
        Ok(received.map(|sample| (sample.origin().value(), sample)))
    }

    fn is_the_only_one(&self) -> bool {
        self.depth == 1 && self.service.dynamic_config().number_of_publishers() == 1
    }
}
