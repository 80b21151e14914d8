//! Requests and replies of iceoryx2.

use cell_rt::monotonic_ns;
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{BackpressureStrategy, PortFactory as _, ipc};
use iceoryx2::service::builder::Builder;
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::request_response::PortFactory;
use iceoryx2::service::port_factory::server::ServerCreateError;
use ipc_types::topic::OPERATOR_SERVICE;
use ipc_types::{OperatorReply, OperatorRequest};

use super::cause::{no_place, port_error};
use crate::error::{BusError, RequestError};
use crate::operator::{Answer, Ask, Serve};
use crate::qos;
use crate::site::RunSite;

pub(crate) type Factory = PortFactory<ipc::Service, OperatorRequest, (), OperatorReply, ()>;

/// Requests of one client that are under way.
// A tool has one at a time; the rest is slack for requests that were given up.
const ACTIVE_REQUESTS: usize = 4;
/// Creates the service; called by the keeper only.
pub(crate) fn create_service(builder: Builder<ipc::Service>) -> Result<Factory, String> {
    builder
        .request_response::<OperatorRequest, OperatorReply>()
        .max_servers(qos::MAX_PUBLISHERS)
        .max_clients(qos::MAX_NODES)
        .max_nodes(qos::MAX_NODES)
        .max_active_requests_per_client(ACTIVE_REQUESTS)
        // A stopped client must not stop physics: requests and replies overwrite the oldest.
        .max_response_buffer_size(2)
        .enable_safe_overflow_for_requests(true)
        .enable_safe_overflow_for_responses(true)
        // A client that gave up must not have its request carried out later.
        .enable_fire_and_forget_requests(false)
        .create()
        .map_err(|error| format!("{error:?}"))
}

pub(super) fn ask(service: &Factory, site: &RunSite) -> Result<Box<dyn Ask>, BusError> {
    let limit = service.static_config().max_clients();
    let port = service
        .client_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(|error| match error {
            ClientCreateError::ExceedsMaxSupportedClients => {
                no_place(OPERATOR_SERVICE, "clients", limit)
            }
            error => port_error(OPERATOR_SERVICE, error, site),
        })?;
    Ok(Box::new(port))
}

pub(super) fn serve(service: &Factory, site: &RunSite) -> Result<Box<dyn Serve>, BusError> {
    let limit = service.static_config().max_servers();
    let port = service
        .server_builder()
        .backpressure_strategy(BackpressureStrategy::DiscardData)
        .create()
        .map_err(|error| match error {
            ServerCreateError::ExceedsMaxSupportedServers => {
                no_place(OPERATOR_SERVICE, "servers", limit)
            }
            error => port_error(OPERATOR_SERVICE, error, site),
        })?;
    Ok(Box::new(port))
}

impl Ask for Client<ipc::Service, OperatorRequest, (), OperatorReply, ()> {
    fn send(&self, request: &OperatorRequest) -> Result<Option<Box<dyn Answer>>, RequestError> {
        let pending = self
            .send_copy(*request)
            .map_err(|error| RequestError::Send(format!("{error:?}")))?;
        let is_sent = pending.number_of_server_connections() > 0;
        Ok(is_sent.then(|| Box::new(pending) as Box<dyn Answer>))
    }

    fn now_ns(&self) -> u64 {
        monotonic_ns()
    }
}

impl Answer for PendingResponse<ipc::Service, OperatorRequest, (), OperatorReply, ()> {
    fn is_connected(&self) -> bool {
        Self::is_connected(self)
    }

    fn receive(&self) -> Option<OperatorReply> {
        let reply = Self::receive(self).ok().flatten()?;
        Some(*reply.payload())
    }
}

impl Serve for Server<ipc::Service, OperatorRequest, (), OperatorReply, ()> {
    fn next(
        &self,
        answer: &mut dyn FnMut(&OperatorRequest) -> Option<OperatorReply>,
    ) -> Option<bool> {
        // An error of the transport ends this look, not the cycle:
        // the client gives up at its timeout.
        let active = self.receive().ok().flatten()?;
        let reply = answer(active.payload());
        // A client that has stopped waiting must not stop the others.
        Some(reply.is_some_and(|reply| active.send_copy(reply).is_ok()))
    }

    fn now_ns(&self) -> u64 {
        monotonic_ns()
    }
}
