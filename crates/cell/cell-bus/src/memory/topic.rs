//! A topic in memory.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

use cell_rt::Clock as _;
use ipc_types::header::Message;

use super::MemorySite;
use crate::error::PublishError;
use crate::factory::Limits;
use crate::reader::{self, NoConnection};
use crate::writer::{self, Loan};

/// A topic: its readers, to which each writer connects by itself.
#[derive(Debug)]
pub(super) struct Topic<T> {
    limits: Limits,
    readers: RefCell<Vec<Weak<Inbox<T>>>>,
    writers: Cell<usize>,
    /// Writers so far, each of which has the number as its id.
    opened: Cell<u128>,
}

impl<T> Topic<T> {
    pub(super) fn new(limits: Limits) -> Self {
        Self {
            limits,
            readers: RefCell::default(),
            writers: Cell::new(0),
            opened: Cell::new(0),
        }
    }
}

/// Messages that wait for a reader, by writer.
type Inbox<T> = RefCell<Vec<Queue<T>>>;

#[derive(Debug)]
struct Queue<T> {
    writer: u128,
    messages: VecDeque<Rc<T>>,
}

/// Keeps the newest `most` messages of `queue`.
fn push<T>(queue: &mut VecDeque<Rc<T>>, message: &Rc<T>, most: usize) {
    queue.push_back(message.clone());
    while queue.len() > most {
        queue.pop_front();
    }
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
            places: RefCell::default(),
        }))
    }
}

impl<T> Connections<T> {
    /// Gives the history to readers that joined.
    fn update(&self) {
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
            };
            for message in self.history.borrow().iter() {
                push(&mut queue.messages, message, self.topic.limits.depth);
            }
            inbox.borrow_mut().push(queue);
            known.push(reader.clone());
        }
    }

    fn send(&self, message: &Rc<T>) {
        if !self.site.effects().happens() {
            return;
        }
        self.update();
        let limits = self.topic.limits;
        for reader in self.readers.borrow().iter().filter_map(Weak::upgrade) {
            for queue in reader.borrow_mut().iter_mut() {
                if queue.writer == self.id {
                    push(&mut queue.messages, message, limits.depth);
                }
            }
        }
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
            connections: self.0.clone(),
        })
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
        self.connections.send(&self.message);
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
    pub(super) fn new(topic: Rc<Topic<T>>) -> Self {
        let inbox = Rc::default();
        let mut readers = topic.readers.borrow_mut();
        readers.retain(|reader| reader.strong_count() > 0);
        readers.push(Rc::downgrade(&inbox));
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
        let mut inbox = self.inbox.borrow_mut();
        if let [only] = inbox.as_mut_slice() {
            let message = only.messages.pop_front();
            return Ok(message.map(|message| (only.writer, message)));
        }
        // Messages of several writers come in any order.
        let count = inbox.len();
        let first = self.looks % count.max(1);
        self.looks += 1;
        let next = |queue: &mut Queue<T>| Some((queue.writer, queue.messages.pop_front()?));
        let (before, from) = inbox.split_at_mut(first);
        Ok(from.iter_mut().chain(before).find_map(next))
    }

    fn is_the_only_one(&self) -> bool {
        self.topic.limits.depth == 1 && self.topic.writers.get() == 1
    }
}
