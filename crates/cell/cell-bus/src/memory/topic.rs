//! A topic in memory.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

use cell_rt::Clock as _;
use ipc_types::header::Message;

use super::MemorySite;
use super::disturbance::{Disturbance, damaged};
use crate::error::PublishError;
use crate::factory::Limits;
use crate::reader::{self, NoConnection};
use crate::writer::{self, Loan};

/// A topic: its readers, to which each writer connects by itself.
#[derive(Debug)]
pub(super) struct Topic<T> {
    limits: Limits,
    /// What happens to the next message.
    disturbance: Rc<Cell<Option<Disturbance>>>,
    readers: RefCell<Vec<Weak<Inbox<T>>>>,
    /// Readers so far.
    joined: Cell<u64>,
    writers: Cell<usize>,
    /// Writers so far, each of which has the number as its id.
    opened: Cell<u128>,
}

impl<T> Topic<T> {
    pub(super) fn new(limits: Limits, disturbance: Rc<Cell<Option<Disturbance>>>) -> Self {
        Self {
            limits,
            disturbance,
            readers: RefCell::default(),
            joined: Cell::new(0),
            writers: Cell::new(0),
            opened: Cell::new(0),
        }
    }
}

/// Messages that wait for a reader.
#[derive(Debug)]
struct Inbox<T> {
    /// By writer.
    queues: RefCell<Vec<Queue<T>>>,
    /// Whether it gets every message as it was sent.
    is_faithful: bool,
}

#[derive(Debug)]
struct Queue<T> {
    writer: u128,
    messages: VecDeque<Rc<T>>,
    /// Comes again once it was taken, unless a newer one came meanwhile.
    again: Option<Rc<T>>,
}

impl<T> Queue<T> {
    fn take(&mut self) -> Option<Rc<T>> {
        let message = self.messages.pop_front()?;
        let again = self.again.take_if(|again| Rc::ptr_eq(again, &message));
        // It must not displace a newer one, which lockstep waits for.
        if self.messages.is_empty() {
            self.messages.extend(again);
        }
        Some(message)
    }
}

/// Keeps the newest `most` messages of `queue`.
fn push<T>(queue: &mut VecDeque<Rc<T>>, message: &Rc<T>, most: usize) {
    queue.push_back(message.clone());
    while queue.len() > most {
        queue.pop_front();
    }
}

/// To whom a message is delivered, and how often.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Delivery {
    /// Once to readers that get the messages as they were sent.
    Faithful,
    /// Once to all others.
    Once,
    /// Twice to all others, the second time when they have taken it.
    Twice,
}

/// Places that a writer keeps: more than its readers and its history hold of most topics.
const PLACES: usize = 16;

/// A writing port.
#[derive(Debug)]
pub(crate) struct Outlet<T>(Rc<Connections<T>>);

#[derive(Debug)]
struct Connections<T> {
    topic: Rc<Topic<T>>,
    site: MemorySite,
    id: u128,
    history: RefCell<VecDeque<Rc<T>>>,
    readers: RefCell<Vec<Weak<Inbox<T>>>>,
    /// Readers that had joined at the last look.
    joined: Cell<u64>,
    /// Messages on their way, and how many newer ones come before each.
    held: RefCell<Vec<(u32, Rc<T>)>>,
    /// Places of messages; one without another owner is free.
    places: RefCell<Vec<Rc<T>>>,
}

impl<T: Message> Outlet<T> {
    pub(super) fn new(topic: Rc<Topic<T>>, site: &MemorySite) -> Self {
        topic.writers.update(|writers| writers + 1);
        topic.opened.update(|id| id + 1);
        let id = topic.opened.get();
        Self(Rc::new(Connections {
            topic,
            site: site.clone(),
            id,
            history: RefCell::default(),
            readers: RefCell::default(),
            joined: Cell::new(0),
            held: RefCell::default(),
            places: RefCell::default(),
        }))
    }
}

impl<T> Connections<T> {
    /// Gives the history to readers that joined.
    fn update(&self) {
        let joined = self.topic.joined.get();
        if self.joined.replace(joined) == joined {
            return;
        }
        let mut known = self.readers.borrow_mut();
        known.retain(|reader| reader.strong_count() > 0);
        for reader in self.topic.readers.borrow().iter() {
            if known.iter().any(|known| known.ptr_eq(reader)) {
                continue;
            }
            let Some(inbox) = reader.upgrade() else {
                continue;
            };
            let mut queue = Queue {
                writer: self.id,
                messages: VecDeque::new(),
                again: None,
            };
            for message in self.history.borrow().iter() {
                push(&mut queue.messages, message, self.topic.limits.depth);
            }
            inbox.queues.borrow_mut().push(queue);
            known.push(reader.clone());
        }
    }

    /// Puts `message` into the queues of readers.
    fn deliver(&self, message: &Rc<T>, delivery: Delivery) {
        let depth = self.topic.limits.depth;
        let is_faithful = delivery == Delivery::Faithful;
        let readers = self.readers.borrow();
        let readers = readers.iter().filter_map(Weak::upgrade);
        for reader in readers.filter(|reader| reader.is_faithful == is_faithful) {
            for queue in reader.queues.borrow_mut().iter_mut() {
                if queue.writer == self.id {
                    push(&mut queue.messages, message, depth);
                    queue.again = (delivery == Delivery::Twice).then(|| message.clone());
                }
            }
        }
    }

    /// Delivers what had to wait for the message that was sent.
    fn deliver_held(&self) {
        let mut held = self.held.borrow_mut();
        for (after, _) in held.iter_mut() {
            *after = after.saturating_sub(1);
        }
        for (_, message) in held.extract_if(.., |(after, _)| *after == 0) {
            self.deliver(&message, Delivery::Once);
        }
    }
}

impl<T: Message> Connections<T> {
    fn send(&self, message: &Rc<T>) {
        self.update();
        self.deliver(message, Delivery::Faithful);
        let disturbance = self.topic.disturbance.take();
        let next = disturbance.and_then(Disturbance::next);
        self.topic.disturbance.set(next);
        match disturbance {
            None => self.deliver(message, Delivery::Once),
            Some(Disturbance::Damage { draw }) => {
                let damaged = damaged(message.as_ref(), draw).map(Rc::new);
                self.deliver(damaged.as_ref().unwrap_or(message), Delivery::Once);
            }
            Some(Disturbance::Again { after: 0, .. }) => self.deliver(message, Delivery::Twice),
            Some(Disturbance::Again { after, .. }) => {
                self.deliver(message, Delivery::Once);
                self.held.borrow_mut().push((after + 1, message.clone()));
            }
            Some(Disturbance::Late { after }) => {
                self.held.borrow_mut().push((after + 1, message.clone()));
            }
        }
        if !self.held.borrow().is_empty() {
            self.deliver_held();
        }
        let limits = self.topic.limits;
        push(&mut self.history.borrow_mut(), message, limits.history);
    }
}

impl<T> Drop for Outlet<T> {
    fn drop(&mut self) {
        self.0.topic.writers.update(|writers| writers - 1);
    }
}

/// A message that is being written.
pub(crate) struct Sheet<T> {
    message: Rc<T>,
    /// Whether a reader may have a reference to it.
    is_read: bool,
    connections: Rc<Connections<T>>,
}

impl<T: Message> writer::Outlet for Outlet<T> {
    type Message = T;
    type Loan = Sheet<T>;

    fn loan(&self) -> Result<Sheet<T>, PublishError> {
        let mut places = self.0.places.borrow_mut();
        let free = places.iter().position(|place| Rc::strong_count(place) == 1);
        // A place is written as it is: to zero a state of 20 kB takes longer than to send it.
        let place = free.map(|free| places.swap_remove(free));
        Ok(Sheet {
            message: place.unwrap_or_else(|| Rc::new(T::zeroed())),
            is_read: true,
            connections: self.0.clone(),
        })
    }

    fn copy_of(&self, message: &T) -> Result<Sheet<T>, PublishError> {
        let mut copy = self.loan()?;
        copy.is_read = self.0.site.inner.has_recorder.get();
        if copy.is_read {
            *copy.message() = *message;
        }
        Ok(copy)
    }

    fn update_connections(&self) -> bool {
        self.0.update();
        true
    }

    fn now_ns(&self) -> u64 {
        self.0.site.now_ns()
    }
}

impl<T: Message> Loan<T> for Sheet<T> {
    fn message(&mut self) -> &mut T {
        // Never copied: this is the only owner until it is sent.
        Rc::make_mut(&mut self.message)
    }

    fn send(self) -> Result<(), PublishError> {
        let site = &self.connections.site;
        if site.effects().happens() {
            let (connections, message) = (self.connections.clone(), self.message.clone());
            let is_read = self.is_read;
            site.inner.cut.pass(move || {
                if is_read {
                    connections.send(&message);
                }
            });
        }
        let mut places = self.connections.places.borrow_mut();
        if places.len() < PLACES {
            places.push(self.message);
        }
        Ok(())
    }
}

/// A reading port.
#[derive(Debug)]
pub(crate) struct Inlet<T> {
    topic: Rc<Topic<T>>,
    inbox: Rc<Inbox<T>>,
    /// Looks for a message so far.
    looks: usize,
}

impl<T: Message> Inlet<T> {
    pub(super) fn new(topic: Rc<Topic<T>>, is_faithful: bool) -> Self {
        let inbox = Rc::new(Inbox {
            queues: RefCell::default(),
            is_faithful,
        });
        let mut readers = topic.readers.borrow_mut();
        readers.retain(|reader| reader.strong_count() > 0);
        readers.push(Rc::downgrade(&inbox));
        topic.joined.update(|joined| joined + 1);
        drop(readers);
        Self {
            topic,
            inbox,
            looks: 0,
        }
    }
}

impl<T: Message> reader::Inlet for Inlet<T> {
    type Message = T;
    type Sample = Rc<T>;

    fn receive(&mut self) -> Result<Option<(u128, Rc<T>)>, NoConnection> {
        let mut inbox = self.inbox.queues.borrow_mut();
        if let [only] = inbox.as_mut_slice() {
            return Ok(only.take().map(|message| (only.writer, message)));
        }
        // Messages of several writers come in any order.
        let count = inbox.len();
        let first = self.looks % count.max(1);
        self.looks += 1;
        let next = |queue: &mut Queue<T>| Some((queue.writer, queue.take()?));
        let (before, from) = inbox.split_at_mut(first);
        Ok(from.iter_mut().chain(before).find_map(next))
    }

    fn is_the_only_one(&self) -> bool {
        self.topic.limits.depth == 1 && self.topic.writers.get() == 1
    }
}
