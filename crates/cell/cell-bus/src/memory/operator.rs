//! Requests and replies in memory.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

use cell_rt::Clock as _;
use ipc_types::{OperatorReply, OperatorRequest};

use super::MemorySite;
use crate::error::RequestError;
use crate::operator::{Answer, Ask, Serve};

/// Requests that wait for physics.
#[derive(Debug, Default)]
pub(super) struct Exchange {
    waiting: RefCell<VecDeque<Rc<Call>>>,
    /// Requests that no server will answer: their clients wait until they give up.
    lost: RefCell<Vec<Rc<Call>>>,
    servers: Cell<usize>,
}

#[derive(Debug)]
struct Call {
    request: OperatorRequest,
    reply: Weak<Cell<Option<OperatorReply>>>,
}

/// The end that sends requests.
#[derive(Debug)]
pub(super) struct Client {
    exchange: Rc<Exchange>,
    now_ns: Rc<Cell<u64>>,
}

impl Client {
    pub(super) fn new(exchange: &Rc<Exchange>, now_ns: Rc<Cell<u64>>) -> Self {
        let exchange = exchange.clone();
        Self { exchange, now_ns }
    }
}

impl Ask for Client {
    fn send(&self, request: &OperatorRequest) -> Result<Option<Box<dyn Answer>>, RequestError> {
        if self.exchange.servers.get() == 0 {
            return Ok(None);
        }
        let reply = Rc::default();
        let call = Rc::new(Call {
            request: *request,
            reply: Rc::downgrade(&reply),
        });
        let answer = Box::new(Pending {
            call: Rc::downgrade(&call),
            reply,
        });
        self.exchange.waiting.borrow_mut().push_back(call);
        Ok(Some(answer))
    }

    fn now_ns(&self) -> u64 {
        self.now_ns.get()
    }
}

#[derive(Debug)]
struct Pending {
    /// Gone once it was answered or dropped.
    call: Weak<Call>,
    reply: Rc<Cell<Option<OperatorReply>>>,
}

impl Answer for Pending {
    fn is_connected(&self) -> bool {
        self.call.strong_count() > 0
    }

    fn receive(&self) -> Option<OperatorReply> {
        self.reply.take()
    }
}

/// The end that replies.
#[derive(Debug)]
pub(super) struct Server {
    exchange: Rc<Exchange>,
    site: MemorySite,
}

impl Server {
    pub(super) fn new(exchange: &Rc<Exchange>, site: &MemorySite) -> Self {
        exchange.servers.update(|servers| servers + 1);
        let (exchange, site) = (exchange.clone(), site.clone());
        Self { exchange, site }
    }
}

impl Serve for Server {
    fn next(
        &self,
        answer: &mut dyn FnMut(&OperatorRequest) -> Option<OperatorReply>,
    ) -> Option<bool> {
        loop {
            let call = self.exchange.waiting.borrow_mut().pop_front()?;
            // A client that gave up must not have its request carried out later.
            let Some(place) = call.reply.upgrade() else {
                continue;
            };
            let reply = answer(&call.request);
            if self.site.effects().happens() {
                let cut = &self.site.inner.cut;
                // The client loses its request with the reply.
                cut.pass(move || {
                    place.set(reply);
                    drop(call);
                });
            }
            return Some(reply.is_some());
        }
    }

    fn now_ns(&self) -> u64 {
        self.site.now_ns()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.exchange.servers.update(|servers| servers - 1);
        // Requests that only it had are lost with it, which their clients do not see.
        if self.exchange.servers.get() == 0 {
            let waiting = self.exchange.waiting.take();
            let mut lost = self.exchange.lost.borrow_mut();
            lost.retain(|call| call.reply.strong_count() > 0);
            lost.extend(waiting);
        }
    }
}
