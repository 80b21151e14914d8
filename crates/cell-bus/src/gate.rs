//! A message caused by tick k is used from tick k + 1 on, by everyone.

use std::collections::VecDeque;

use ipc_types::header::Message;

use crate::subscriber::Subscriber;

/// A reader that runs behind its writer by more than this loses the oldest.
const WAITING: usize = 4;

/// Keeps messages back until the tick from which they may be used. Who works on
/// state tick k sees the newest message with `header.tick < k`, whether or not
/// a newer one has arrived already: so the result does not depend on who was
/// faster.
#[derive(Clone, Debug)]
pub struct Gate<T: Message> {
    current: Option<Box<T>>,
    waiting: VecDeque<T>,
}

impl<T: Message> Default for Gate<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Message> Gate<T> {
    /// An empty gate; the only place that allocates, besides the first message.
    pub fn new() -> Self {
        Self {
            current: None,
            waiting: VecDeque::with_capacity(WAITING),
        }
    }

    /// Takes the newest message of `subscriber` in; true when there was one.
    pub fn pull(&mut self, subscriber: &mut Subscriber<T>) -> bool {
        subscriber
            .take()
            .map(|message| self.offer(message))
            .is_some()
    }

    /// Takes a message in. A new generation of the writer, or a tick before one
    /// already here (the scene was reset), empties the gate first: what it
    /// holds belongs to another past.
    pub fn offer(&mut self, message: &T) {
        let header = message.header();
        let last = self
            .waiting
            .back()
            .or(self.current.as_deref())
            .map(Message::header);
        if let Some(last) = last {
            if header.tick < last.tick {
                self.clear();
            } else if header.generation != last.generation {
                // Nothing of the old writer may come up after the new one's.
                self.waiting.clear();
            }
        }
        if self
            .waiting
            .back()
            .is_some_and(|waiting| waiting.header().tick == header.tick)
        {
            self.waiting.pop_back();
        }
        if self.waiting.len() == WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(*message);
    }

    /// The message to use at state tick `tick`: the newest caused by an earlier
    /// one.
    pub fn advance(&mut self, tick: u64) -> Option<&T> {
        while self
            .waiting
            .front()
            .is_some_and(|message| message.header().tick < tick)
        {
            let Some(message) = self.waiting.pop_front() else {
                break;
            };
            match &mut self.current {
                Some(current) => **current = message,
                None => self.current = Some(Box::new(message)),
            }
        }
        self.current()
    }

    /// What the last [`Self::advance`] gave.
    pub fn current(&self) -> Option<&T> {
        self.current.as_deref()
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.current = None;
        self.waiting.clear();
    }
}
