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
use ipc_types::topic::TopicId;

use crate::bell::{Ring, Sleep};
use crate::error::BusError;
use crate::factory::Limits;
use crate::operator::{Ask, Serve};
use crate::qos;

mod cut;
mod disturbance;
mod operator;
#[cfg(test)]
mod tests;
mod topic;

use cut::Cut;
pub use cut::Kept;
pub use disturbance::Disturbance;
use operator::Exchange;
use topic::{Inlet, Outlet, Topic};

/// Topics, doorbells and requests of one run, and its virtual time. Its clones are the same
/// site.
#[derive(Clone, Debug)]
pub struct MemorySite {
    inner: Rc<Inner>,
    /// Whether readers that are opened here get every message as it was sent.
    is_faithful: bool,
}

#[derive(Debug)]
struct Inner {
    topics: RefCell<BTreeMap<String, Entry>>,
    bells: RefCell<BTreeMap<String, Rc<Bell>>>,
    requests: Rc<Exchange>,
    now_ns: Rc<Cell<u64>>,
    effects: Effects,
    cut: Rc<Cut>,
    /// Whether copies for a recorder are made also before it reads them.
    has_recorder: Cell<bool>,
}

#[derive(Debug)]
struct Entry {
    limits: Limits,
    /// What happens to the next message.
    disturbance: Rc<Cell<Option<Disturbance>>>,
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
                disturbance: Rc::default(),
                topic: None,
            };
            (topic.service(), entry)
        });
        let now_ns = Rc::default();
        let inner = Rc::new(Inner {
            topics: RefCell::new(topics.collect()),
            bells: RefCell::default(),
            requests: Rc::default(),
            cut: Rc::new(Cut::new(&now_ns)),
            now_ns,
            effects: Effects::default(),
            has_recorder: Cell::new(true),
        });
        Self {
            inner,
            is_faithful: false,
        }
    }

    /// The same site for a cell that no recorder joins: its copies have no content. To send one is
    /// an effect as before.
    pub fn without_recorder(self) -> Self {
        self.inner.has_recorder.set(false);
        self
    }

    /// The same site for a reader that sees what was sent, whatever happens to it on its way.
    pub fn faithful(&self) -> Self {
        Self {
            is_faithful: true,
            ..self.clone()
        }
    }

    /// Lets `disturbance` happen to the next message on `topic`; false where no port of it was
    /// opened.
    pub fn disturb(&self, topic: TopicId, disturbance: Disturbance) -> bool {
        let topics = self.inner.topics.borrow();
        let entry = topics.get(&topic.service());
        let entry = entry.filter(|entry| entry.topic.is_some());
        entry.is_some_and(|entry| {
            entry.disturbance.set(Some(disturbance));
            true
        })
    }

    /// Interrupts the turn that follows after `effects` messages, rings and replies: the clock
    /// advances by `gap_ns`, and what it sends then is kept for [`Self::end_cut`].
    pub fn cut_after(&self, effects: u64, gap_ns: u64) {
        self.inner.cut.begin(effects, gap_ns);
    }

    /// The turn is over; what it did after its interruption, to let happen later.
    pub fn end_cut(&self) -> Vec<Kept> {
        self.inner.cut.end()
    }

    /// Sets the time of the clock, which stamps messages.
    pub fn set_now_ns(&self, now_ns: u64) {
        self.inner.now_ns.set(now_ns);
    }

    /// What its processes may still do.
    pub fn effects(&self) -> &Effects {
        &self.inner.effects
    }

    pub(crate) fn outlet<T: Message>(&self, name: &str) -> Result<Outlet<T>, BusError> {
        Ok(Outlet::new(self.topic(name)?, self))
    }

    pub(crate) fn inlet<T: Message>(&self, name: &str) -> Result<Inlet<T>, BusError> {
        Ok(Inlet::new(self.topic(name)?, self.is_faithful))
    }

    fn topic<T: Message>(&self, name: &str) -> Result<Rc<Topic<T>>, BusError> {
        let mut topics = self.inner.topics.borrow_mut();
        let entry = topics.get_mut(name).ok_or_else(|| BusError::Open {
            service: name.to_owned(),
            reason: "the model has no such topic".to_owned(),
            waited_ms: 0,
        })?;
        let (limits, disturbance) = (entry.limits, entry.disturbance.clone());
        let new = || Rc::new(Topic::<T>::new(limits, disturbance)) as Rc<dyn Any>;
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
        let mut bells = self.inner.bells.borrow_mut();
        let new = || {
            Rc::new(Bell {
                rang: Cell::default(),
                effects: self.inner.effects.clone(),
                cut: self.inner.cut.clone(),
            })
        };
        bells.entry(name.to_owned()).or_insert_with(new).clone()
    }

    pub(crate) fn ask(&self) -> Box<dyn Ask> {
        Box::new(operator::Client::new(
            &self.inner.requests,
            self.inner.now_ns.clone(),
        ))
    }

    pub(crate) fn serve(&self) -> Box<dyn Serve> {
        Box::new(operator::Server::new(&self.inner.requests, self))
    }
}

impl Clock for MemorySite {
    fn now_ns(&self) -> u64 {
        self.inner.now_ns.get()
    }
}

#[derive(Debug)]
struct Bell {
    /// Since the last look.
    rang: Cell<bool>,
    effects: Effects,
    cut: Rc<Cut>,
}

impl Ring for Rc<Bell> {
    fn ring(&self) -> bool {
        if self.effects.happens() {
            let bell = self.clone();
            self.cut.pass(move || bell.rang.set(true));
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
