//! The wiring of a model: all processes of a cell in one thread, with virtual time.
//!
//! It behaves as the services of iceoryx2 do with the settings of `qos`: a reader that is behind
//! loses the oldest message; a late one gets the history when the writer publishes or lets it
//! in; messages of a writer that is gone can still be read. Nothing waits.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::time::Duration;

use cell_rt::{Clock, Effects};
use ipc_types::header::Message;

use crate::bell::{Ring, Sleep};
use crate::error::BusError;
use crate::factory::Limits;
use crate::operator::{Ask, Serve};
use crate::qos;

mod operator;
mod topic;

use operator::Exchange;
use topic::{Inlet, Outlet, Topic};

/// Topics, doorbells and requests of one run, and its virtual time. Its clones are the same
/// site.
#[derive(Clone, Debug)]
pub struct MemorySite(Rc<Inner>);

#[derive(Debug)]
struct Inner {
    topics: RefCell<BTreeMap<String, Entry>>,
    bells: RefCell<BTreeMap<String, Rc<Bell>>>,
    requests: Rc<Exchange>,
    now_ns: Rc<Cell<u64>>,
    effects: Effects,
}

#[derive(Debug)]
struct Entry {
    limits: Limits,
    /// A [`Topic`] of the type that was opened first.
    topic: Option<Rc<dyn Any>>,
}

impl MemorySite {
    /// The site of a cell of `arms` arms, at time 0.
    pub fn new(arms: u8) -> Self {
        let topics = qos::topics(arms).into_iter().map(|topic| {
            let limits = Limits::of(topic);
            let entry = Entry {
                limits,
                topic: None,
            };
            (topic.service(), entry)
        });
        Self(Rc::new(Inner {
            topics: RefCell::new(topics.collect()),
            bells: RefCell::default(),
            requests: Rc::default(),
            now_ns: Rc::default(),
            effects: Effects::default(),
        }))
    }

    /// Sets the time of the clock, which stamps messages.
    pub fn set_now_ns(&self, now_ns: u64) {
        self.0.now_ns.set(now_ns);
    }

    /// What its processes may still do.
    pub fn effects(&self) -> &Effects {
        &self.0.effects
    }

    pub(crate) fn outlet<T: Message>(&self, name: &str) -> Result<Outlet<T>, BusError> {
        Ok(Outlet::new(self.topic(name)?, self))
    }

    pub(crate) fn inlet<T: Message>(&self, name: &str) -> Result<Inlet<T>, BusError> {
        Ok(Inlet::new(self.topic(name)?))
    }

    fn topic<T: Message>(&self, name: &str) -> Result<Rc<Topic<T>>, BusError> {
        let mut topics = self.0.topics.borrow_mut();
        let entry = topics.get_mut(name).ok_or_else(|| BusError::Open {
            service: name.to_owned(),
            reason: "the model has no such topic".to_owned(),
            waited_ms: 0,
        })?;
        let limits = entry.limits;
        let new = || Rc::new(Topic::<T>::new(limits)) as Rc<dyn Any>;
        let topic = entry.topic.get_or_insert_with(new).clone();
        topic.downcast().map_err(|_| BusError::Version {
            service: name.to_owned(),
            theirs: "another type".to_owned(),
            ours: core::any::type_name::<T>().to_owned(),
        })
    }

    pub(crate) fn ring(&self, name: &str) -> Box<dyn Ring> {
        Box::new(self.bell(name))
    }

    pub(crate) fn sleep(&self, name: &str) -> Box<dyn Sleep> {
        Box::new(self.bell(name))
    }

    fn bell(&self, name: &str) -> Rc<Bell> {
        let mut bells = self.0.bells.borrow_mut();
        let new = || {
            Rc::new(Bell {
                rang: Cell::default(),
                effects: self.0.effects.clone(),
            })
        };
        bells.entry(name.to_owned()).or_insert_with(new).clone()
    }

    pub(crate) fn ask(&self) -> Box<dyn Ask> {
        Box::new(operator::Client::new(
            &self.0.requests,
            self.0.now_ns.clone(),
        ))
    }

    pub(crate) fn serve(&self) -> Box<dyn Serve> {
        Box::new(operator::Server::new(&self.0.requests, self))
    }
}

impl Clock for MemorySite {
    fn now_ns(&self) -> u64 {
        self.0.now_ns.get()
    }
}

#[derive(Debug)]
struct Bell {
    /// Since the last look.
    rang: Cell<bool>,
    effects: Effects,
}

impl Ring for Rc<Bell> {
    fn ring(&self) -> bool {
        if self.effects.happens() {
            self.rang.set(true);
        }
        true
    }
}

impl Sleep for Rc<Bell> {
    fn wait(&self, _timeout: Duration) -> bool {
        self.rang.take()
    }

    fn drain(&self) -> bool {
        self.rang.take()
    }
}
