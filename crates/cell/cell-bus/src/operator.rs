//! Requests of people and tools, and their answers.
//!
//! Requests use request-response, not a topic: a sample of a publisher that is dropped before
//! its subscriber has mapped it is lost, and a tool lives for milliseconds. A reply names the
//! tick at which the request took effect, so that a script and a person have the same record
//! (ADR 0001).

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

/// Requests of one client that are under way.
// A tool has one at a time; the rest is slack for requests that were given up.
const ACTIVE_REQUESTS: usize = 4;
/// Interval at which a client looks for its reply.
// Half a cycle of physics, which replies once a cycle.
const POLL_NS: u64 = 500_000;

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

fn port_error(reason: impl core::fmt::Debug) -> BusError {
    BusError::Port {
        service: OPERATOR_SERVICE.to_owned(),
        reason: format!("{reason:?}"),
    }
}

fn stamp<T: Message>(message: &mut T, identity: Identity, seq: u64) {
    // The tick is the caller's; all other fields of the header are the port's.
    let tick = message.header().tick;
    *message.header_mut() = Header {
        run: identity.run,
        generation: identity.generation,
        seq,
        publish_ns: monotonic_ns(),
        ..Header::caused_by::<T>(tick)
    };
}

/// Sends requests to physics and waits for the replies.
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

    /// Sends `request` and waits up to `timeout` for the reply, which carries the tick at which
    /// it took effect. During a start of physics the request waits for it. A request without an
    /// answer has not been carried out, or physics died while handling it.
    pub fn request(
        &mut self,
        mut request: OperatorRequest,
        timeout: Duration,
    ) -> Result<OperatorReply, RequestError> {
        // Refused here with a reason; physics drops an invalid request without a reply.
        request.validate().map_err(RequestError::Invalid)?;
        let start_ns = monotonic_ns();
        let end_ns = start_ns.saturating_add(u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX));
        // A restart of physics leaves a moment without a
        // server; the request is sent again then.
        loop {
            self.seq += 1;
            stamp(&mut request, self.identity, self.seq);
            let pending = self
                .port
                .send_copy(request)
                .map_err(|error| RequestError::Send(format!("{error:?}")))?;
            // Exactly once: with a server connected the request
            // is out and must not be repeated.
            if pending.number_of_server_connections() > 0 {
                return wait_for_reply(&pending, self.identity.run, end_ns)
                    .ok_or(RequestError::NoAnswer(timeout.as_millis()));
            }
            // No process received it, so it may be sent again.
            if monotonic_ns() >= end_ns {
                return Err(RequestError::NoAnswer(timeout.as_millis()));
            }
            sleep_until((monotonic_ns() + 10 * POLL_NS).min(end_ns));
        }
    }
}

/// Waits for a reply until it arrives, the server drops the request without one, or the time is
/// over.
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
            // A reply of another run or with invalid fields is damaged: waiting continues.
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

/// Answers requests, from within the cycle of physics.
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

    /// Passes up to `max` waiting requests to `answer` and sends its result; the reply's
    /// `header.tick` is the tick at which the request takes effect. Invalid requests and those
    /// of another run get no answer. Returns the number of replies sent. Never blocks.
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
            // An error of the transport ends this look, not the cycle:
            // the client gives up at its timeout.
            let Ok(Some(active)) = self.port.receive() else {
                break;
            };
            let request = active.payload();
            // Not answered: a reply would tell a program of
            // another build that it was understood.
            let ours = request.header.run == self.identity.run
                && request.header.schema == OperatorRequest::SCHEMA;
            if !ours || request.validate().is_err() {
                self.rejected += 1;
                continue;
            }
            let mut reply = answer(request);
            self.seq += 1;
            stamp(&mut reply, self.identity, self.seq);
            // A client that has stopped waiting must not stop the others.
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
