//! Requests of people and tools, and their answers.
//!
//! Requests use request-response, not a topic: a sample of a publisher that is dropped before
//! its subscriber has mapped it is lost, and a tool lives for milliseconds. A reply names the
//! tick at which the request took effect, so that a script and a person have the same record
//! (ADR 0001).

use core::fmt::Debug;
use std::time::Duration;

use cell_rt::{monotonic_ns, sleep_until};
use ipc_types::header::{Header, Message};
use ipc_types::{OperatorReply, OperatorRequest, Validate, Wire};

use crate::error::RequestError;
use crate::identity::Identity;

/// Interval at which a client looks for its reply.
// Half a cycle of physics, which replies once a cycle.
const POLL_NS: u64 = 500_000;

/// The end of one of the wirings that sends requests.
pub(crate) trait Ask: Debug {
    /// `None` if no server was connected: the request was not sent.
    fn send(&self, request: &OperatorRequest) -> Result<Option<Box<dyn Answer>>, RequestError>;
    /// Time for the stamp of a request.
    fn now_ns(&self) -> u64;
}

/// A request under way.
pub(crate) trait Answer: Debug {
    /// False after the reply, or if there will be none.
    fn is_connected(&self) -> bool;
    fn receive(&self) -> Option<OperatorReply>;
}

/// The end of one of the wirings that replies.
pub(crate) trait Serve: Debug {
    /// Passes the next request to `answer` and sends its reply, if it gives one. `None` if no
    /// request waits, else whether a reply was sent.
    fn next(
        &self,
        answer: &mut dyn FnMut(&OperatorRequest) -> Option<OperatorReply>,
    ) -> Option<bool>;
    /// Time for the stamp of a reply.
    fn now_ns(&self) -> u64;
}

fn stamp<T: Message>(message: &mut T, identity: Identity, seq: u64, now_ns: u64) {
    // The tick is the caller's; all other fields of the header are the port's.
    let tick = message.header().tick;
    *message.header_mut() = Header {
        run: identity.run,
        generation: identity.generation,
        seq,
        publish_ns: now_ns,
        ..Header::caused_by::<T>(tick)
    };
}

/// Sends requests to physics and waits for the replies.
#[derive(Debug)]
pub struct OperatorClient {
    port: Box<dyn Ask>,
    identity: Identity,
    seq: u64,
}

/// A request that was sent.
#[derive(Debug)]
pub struct PendingReply {
    port: Box<dyn Answer>,
    run: u64,
}

/// The state of a request.
#[derive(Clone, Debug)]
pub enum Answered {
    /// Physics has not replied.
    Waiting,
    /// The reply.
    Reply(Box<OperatorReply>),
    /// Physics dropped the request without a reply, or ended.
    Dropped,
}

impl PendingReply {
    /// The reply, if it has arrived. Never waits.
    pub fn take(&self) -> Answered {
        // A reply also ends the connection, so look at that before the reply.
        let connected = self.port.is_connected();
        while let Some(reply) = self.port.receive() {
            // A reply of another run or with invalid fields is damaged: waiting continues.
            if reply.header.run == self.run && reply.validate().is_ok() {
                return Answered::Reply(Box::new(reply));
            }
        }
        if connected {
            Answered::Waiting
        } else {
            Answered::Dropped
        }
    }
}

impl OperatorClient {
    pub(crate) fn new(port: Box<dyn Ask>, identity: Identity) -> Self {
        Self {
            port,
            identity,
            seq: 0,
        }
    }

    /// Sends `request` without waiting; `None` if physics is not there, and nothing was sent.
    /// A reply that is dropped withdraws the request.
    pub fn send(
        &mut self,
        mut request: OperatorRequest,
    ) -> Result<Option<PendingReply>, RequestError> {
        // Refused here with a reason; physics drops an invalid request without a reply.
        request.validate().map_err(RequestError::Invalid)?;
        self.seq += 1;
        stamp(&mut request, self.identity, self.seq, self.port.now_ns());
        let run = self.identity.run;
        let port = self.port.send(&request)?;
        Ok(port.map(|port| PendingReply { port, run }))
    }

    /// Sends `request` and waits up to `timeout` for the reply, which carries the tick at which
    /// it took effect. During a start of physics the request waits for it. A request without an
    /// answer has not been carried out, or physics died while handling it.
    pub fn request(
        &mut self,
        request: OperatorRequest,
        timeout: Duration,
    ) -> Result<OperatorReply, RequestError> {
        let start_ns = monotonic_ns();
        let end_ns = start_ns.saturating_add(u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX));
        // A restart of physics leaves a moment without a
        // server; the request is sent again then.
        loop {
            // Exactly once: with a server connected the request
            // is out and must not be repeated.
            if let Some(pending) = self.send(request)? {
                return wait_for_reply(&pending, end_ns)
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
fn wait_for_reply(pending: &PendingReply, end_ns: u64) -> Option<OperatorReply> {
    loop {
        match pending.take() {
            Answered::Reply(reply) => return Some(*reply),
            Answered::Waiting if monotonic_ns() < end_ns => {}
            Answered::Waiting | Answered::Dropped => return None,
        }
        sleep_until(monotonic_ns() + POLL_NS);
    }
}

/// Answers requests, from within the cycle of physics.
#[derive(Debug)]
pub struct OperatorServer {
    port: Box<dyn Serve>,
    identity: Identity,
    seq: u64,
    rejected: u64,
}

impl OperatorServer {
    pub(crate) fn new(port: Box<dyn Serve>, identity: Identity) -> Self {
        Self {
            port,
            identity,
            seq: 0,
            rejected: 0,
        }
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
        let Self {
            port,
            identity,
            seq,
            rejected,
        } = self;
        let mut answered = 0;
        while answered < max {
            let sent = port.next(&mut |request| {
                // Not answered: a reply would tell a program of
                // another build that it was understood.
                let ours = request.header.run == identity.run
                    && request.header.schema == OperatorRequest::SCHEMA;
                if !ours || request.validate().is_err() {
                    *rejected += 1;
                    return None;
                }
                let mut reply = answer(request);
                *seq += 1;
                stamp(&mut reply, *identity, *seq, port.now_ns());
                Some(reply)
            });
            let Some(sent) = sent else {
                break;
            };
            answered += usize::from(sent);
        }
        answered
    }

    /// Requests that were dropped.
    pub fn rejected(&self) -> u64 {
        self.rejected
    }
}
