//! Requests of people and tools, and their answers.

use std::time::Duration;

use cell_rt::{monotonic_ns, sleep_until};
use iceoryx2::pending_response::PendingResponse;
use iceoryx2::port::client::Client;
use iceoryx2::port::server::Server;
use iceoryx2::prelude::{BackpressureStrategy, ipc};
use iceoryx2::service::builder::Builder;
use iceoryx2::service::port_factory::request_response::PortFactory;
use ipc_types::header::{Header, Message};
use ipc_types::topic::OPERATOR_SERVICE;
use ipc_types::{OperatorReply, OperatorRequest, Validate, Wire};

use crate::error::{BusError, RequestError};
use crate::hidden::Hidden;
use crate::identity::Identity;
use crate::qos;

pub(crate) type Factory = PortFactory<ipc::Service, OperatorRequest, (), OperatorReply, ()>;

/// Requests of one client on their way.
const ACTIVE_REQUESTS: usize = 4;
/// How often a client looks for its answer.
const POLL_NS: u64 = 500_000;

/// Creates the service; the keeper's part.
pub(crate) fn create_service(builder: Builder<ipc::Service>) -> Result<Factory, String> {
    builder
        .request_response::<OperatorRequest, OperatorReply>()
        .max_servers(qos::MAX_PUBLISHERS)
        .max_clients(qos::MAX_NODES)
        .max_nodes(qos::MAX_NODES)
        .max_active_requests_per_client(ACTIVE_REQUESTS)
        .max_response_buffer_size(2)
        .enable_safe_overflow_for_requests(true)
        .enable_safe_overflow_for_responses(true)
        // A client that gave up must not have its request carried out later.
        .enable_fire_and_forget_requests(false)
        .create()
        .map_err(|error| format!("{error:?}"))
}

fn port_error(reason: impl core::fmt::Debug) -> BusError {
    BusError::Port {
        service: OPERATOR_SERVICE.to_owned(),
        reason: format!("{reason:?}"),
    }
}

fn stamp<T: Message>(message: &mut T, identity: Identity, seq: u64) {
    let tick = message.header().tick;
    *message.header_mut() = Header {
        run: identity.run,
        generation: identity.generation,
        seq,
        publish_ns: monotonic_ns(),
        ..Header::caused_by::<T>(tick)
    };
}

/// Asks physics, and waits for the answer.
#[derive(Debug)]
pub struct OperatorClient {
    port: Hidden<Client<ipc::Service, OperatorRequest, (), OperatorReply, ()>>,
    identity: Identity,
    seq: u64,
}

impl OperatorClient {
    pub(crate) fn new(service: &Factory, identity: Identity) -> Result<Self, BusError> {
        let port = service
            .client_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(port_error)?;
        Ok(Self {
            port: Hidden::new(port),
            identity,
            seq: 0,
        })
    }

    /// Sends `request` and waits up to `timeout` for the reply, which carries
    /// the tick at which it took effect. While physics is being started the
    /// request waits for it. A request that got no answer has not been carried
    /// out, or physics died over it.
    pub fn request(
        &mut self,
        mut request: OperatorRequest,
        timeout: Duration,
    ) -> Result<OperatorReply, RequestError> {
        request.validate().map_err(RequestError::Invalid)?;
        let start_ns = monotonic_ns();
        let end_ns = start_ns.saturating_add(u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX));
        loop {
            self.seq += 1;
            stamp(&mut request, self.identity, self.seq);
            let pending = self
                .port
                .send_copy(request)
                .map_err(|error| RequestError::Send(format!("{error:?}")))?;
            if pending.number_of_server_connections() > 0 {
                return wait_for_reply(&pending, self.identity.run, end_ns)
                    .ok_or(RequestError::NoAnswer(timeout.as_millis()));
            }
            // No process received it, so it may be said again.
            if monotonic_ns() >= end_ns {
                return Err(RequestError::NoAnswer(timeout.as_millis()));
            }
            sleep_until((monotonic_ns() + 10 * POLL_NS).min(end_ns));
        }
    }
}

/// Looks for a reply until it is there, the server let the request go without
/// one, or the time is over.
fn wait_for_reply(
    pending: &PendingResponse<ipc::Service, OperatorRequest, (), OperatorReply, ()>,
    run: u64,
    end_ns: u64,
) -> Option<OperatorReply> {
    loop {
        // A reply also ends the connection, so look at that before the reply.
        let connected = pending.is_connected();
        while let Some(reply) = pending.receive().ok().flatten() {
            let reply = *reply.payload();
            if reply.header.run == run && reply.validate().is_ok() {
                return Some(reply);
            }
        }
        if !connected || monotonic_ns() >= end_ns {
            return None;
        }
        sleep_until(monotonic_ns() + POLL_NS);
    }
}

/// Answers, from within the cycle of physics.
#[derive(Debug)]
pub struct OperatorServer {
    port: Hidden<Server<ipc::Service, OperatorRequest, (), OperatorReply, ()>>,
    identity: Identity,
    seq: u64,
    rejected: u64,
}

impl OperatorServer {
    pub(crate) fn new(service: &Factory, identity: Identity) -> Result<Self, BusError> {
        let port = service
            .server_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create()
            .map_err(port_error)?;
        Ok(Self {
            port: Hidden::new(port),
            identity,
            seq: 0,
            rejected: 0,
        })
    }

    /// Hands up to `max` waiting requests to `answer` and sends what it
    /// returns; the reply's `header.tick` is the tick the request takes effect.
    /// Requests that make no sense, or are of another run, get no answer.
    /// Returns how many were answered. Never blocks.
    pub fn poll(
        &mut self,
        max: usize,
        mut answer: impl FnMut(&OperatorRequest) -> OperatorReply,
    ) -> usize {
        self.poll_with(max, &mut answer)
    }

    fn poll_with(
        &mut self,
        max: usize,
        answer: &mut dyn FnMut(&OperatorRequest) -> OperatorReply,
    ) -> usize {
        let mut answered = 0;
        while answered < max {
            let Ok(Some(active)) = self.port.receive() else {
                break;
            };
            let request = active.payload();
            let ours = request.header.run == self.identity.run
                && request.header.schema == OperatorRequest::SCHEMA;
            if !ours || request.validate().is_err() {
                self.rejected += 1;
                continue;
            }
            let mut reply = answer(request);
            self.seq += 1;
            stamp(&mut reply, self.identity, self.seq);
            // A client that does not wait any more is its own problem.
            if active.send_copy(reply).is_ok() {
                answered += 1;
            }
        }
        answered
    }

    /// Requests that were dropped.
    pub fn rejected(&self) -> u64 {
        self.rejected
    }
}
